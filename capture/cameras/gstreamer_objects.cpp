// SPDX-License-Identifier: MIT
#include "capture/cameras/gstreamer_objects.h"

#include <string>

#include "engine/core/error.h"

#ifdef __SANITIZE_ADDRESS__
// GLib does not free its old table of names when it grows, because other threads may still read it.
extern "C" {
const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() {
  return "leak:libglib-2.0.so\n";
}
const char* __lsan_default_options();
const char* __lsan_default_options() {
  return "print_suppressions=0";
}
}
#endif

namespace airclay {

void startGStreamer(std::initializer_list<RequiredElement> elements) {
  gst_init(nullptr, nullptr);
  for (const RequiredElement& element : elements)
    if (!GObjectPtr<GstElementFactory>(gst_element_factory_find(element.name)))
      throw Error(std::string("GStreamer has no element ") + element.name + "; install the package " +
                  element.package);
}

GObjectPtr<GstElement> elementOf(GstElement* pipeline, const char* name) {
  return GObjectPtr<GstElement>(gst_bin_get_by_name_recurse_up(GST_BIN(pipeline), name));
}

}  // namespace airclay
