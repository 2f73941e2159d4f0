# Everything comes from Debian 12; packages.txt lists the packages, README.md explains each.
find_package(Threads REQUIRED)
find_package(Vulkan REQUIRED)
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs videoio calib3d aruco)
find_package(PkgConfig REQUIRED)  # GStreamer and FFmpeg have no CMake packages
pkg_check_modules(GSTREAMER REQUIRED IMPORTED_TARGET
  gstreamer-rtsp-server-1.0>=1.22 gstreamer-app-1.0 gstreamer-video-1.0 gio-2.0)
pkg_check_modules(LIBAV REQUIRED IMPORTED_TARGET libavformat>=59 libavcodec libavutil)
find_package(Ceres 2.1 REQUIRED)
find_package(SQLite3 3.37 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(GTest REQUIRED)
find_package(assimp 5.2 REQUIRED)

# Debian's CMake file for OpenSubdiv names a static library that it does not ship.
find_library(OPENSUBDIV_LIBRARY osdCPU REQUIRED)
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)  # header only: see engine/mesh/tiny_gltf.cpp

# The window.
find_package(glfw3 3.3 REQUIRED)
find_package(X11 REQUIRED COMPONENTS Xext)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui REQUIRED)
find_library(IMGUI_LIBRARY imgui REQUIRED)
find_library(STB_LIBRARY stb REQUIRED)
find_file(AIRCLAY_FONT Inter-Regular.otf PATHS /usr/share/fonts/opentype/inter REQUIRED)
