// SPDX-License-Identifier: MIT
// Owners of GObject references, for the sources and the stream server. Only for files that include GStreamer.
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

struct RequiredElement {
  const char* name;
  const char* package;  ///< the Debian package that contains it
};
/// Initializes GStreamer. \throw Error naming an element that is not installed, and its package.
void startGStreamer(std::initializer_list<RequiredElement> elements);

/// The pipeline's element with this name. \pre it exists
GObjectPtr<GstElement> elementOf(GstElement* pipeline, const char* name);

}  // namespace airclay
