// SPDX-License-Identifier: MIT
// What the two ends of a stream share: GObject's owners. Only for files that see GStreamer.
#pragma once

#include <gst/gst.h>

#include <initializer_list>
#include <memory>

namespace airclay {

struct GObjectDeleter {
  void operator()(gpointer object) const { g_object_unref(object); }
  void operator()(GSource* source) const { g_source_unref(source); }
  void operator()(GstSample* sample) const { gst_sample_unref(sample); }
  void operator()(GstMessage* message) const { gst_message_unref(message); }
};
/// Owns one reference.
template <typename T>
using GObjectPtr = std::unique_ptr<T, GObjectDeleter>;

struct NeededElement {
  const char* name;
  const char* package;  ///< Debian's, that it comes in
};
/// Begins to use GStreamer. \throw Error naming an element that is not installed, and its package.
void startGStreamer(std::initializer_list<NeededElement> elements);

/// The element of this name in a pipeline that has one.
GObjectPtr<GstElement> elementOf(GstElement* pipeline, const char* name);

}  // namespace airclay
