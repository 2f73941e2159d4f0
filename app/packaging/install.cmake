# What `cmake --install` installs: the libraries with their public headers, CMake and pkg-config files; the program
# with its man page, shell completions, desktop entry and icon.
include(CMakePackageConfigHelpers)

install(TARGETS airclay airclay_engine airclay_capture EXPORT airclay_targets
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})

# --- headers -------------------------------------------------------------------------------------------------
# A header is public unless it is listed here. tests/install_test.cpp compiles every installed header on its own
# and checks that it includes no internal one.
set(AIRCLAY_INTERNAL_HEADERS
  engine/core/file_io.h
  engine/core/median.h
  engine/clay/dense_pseudoinverse.h
  engine/gpu/one_time.h
  engine/clay/remesh_fit.h
  engine/mesh/cage_repair.h
  engine/mesh/gltf_elements.h
  engine/mesh/mesh_source.h
  engine/mesh/point_merger.h
  engine/gpu/shader_stage.h
  engine/render/renderer_parts.h
  engine/validation/bench_peers.h
  engine/validation/compare_scene.h
  capture/images/quiet_opencv.h
  capture/images/video_index.h
  capture/takes/frame_matcher.h
  capture/takes/image_sets.h
  capture/cameras/gstreamer_objects.h
  capture/cameras/gstreamer_source.h
  capture/cameras/live_feed.h
  capture/takes/timestamps.h
  capture/calibration/aruco_dictionary.h
  capture/calibration/board_exposure.h
  capture/calibration/calibration_parts.h
  capture/calibration/chessboard_detector.h
  capture/calibration/saddle_point.h
  shaders/gpu/triangles_io.h
  shaders/render/renderer_voxels_io.h)
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR}
  ${CMAKE_SOURCE_DIR}/engine/*.h ${CMAKE_SOURCE_DIR}/capture/*.h ${CMAKE_SOURCE_DIR}/shaders/*_io.h
  ${CMAKE_SOURCE_DIR}/shaders/core/io.h)
foreach(header ${AIRCLAY_INTERNAL_HEADERS})
  if(NOT header IN_LIST headers)
    message(FATAL_ERROR "AIRCLAY_INTERNAL_HEADERS lists ${header}, which does not exist")
  endif()
endforeach()
list(REMOVE_ITEM headers ${AIRCLAY_INTERNAL_HEADERS})
foreach(header ${headers})
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${CMAKE_SOURCE_DIR}/${header} DESTINATION ${AIRCLAY_INSTALL_INCLUDEDIR}/${folder})
endforeach()

# --- CMake and pkg-config ------------------------------------------------------------------------------------
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/airclay)
install(EXPORT airclay_targets NAMESPACE airclay:: FILE airclay-targets.cmake DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/airclay-config.cmake.in
  ${CMAKE_BINARY_DIR}/airclay-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/airclay-config-version.cmake COMPATIBILITY SameMinorVersion)
# airclay.pc derives the prefix from its own place, so an installed tree can be moved.
file(RELATIVE_PATH prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${CMAKE_CURRENT_LIST_DIR}/airclay.pc.in ${CMAKE_BINARY_DIR}/airclay.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/airclay-config.cmake ${CMAKE_BINARY_DIR}/airclay-config-version.cmake
  DESTINATION ${package_folder})
install(FILES ${CMAKE_BINARY_DIR}/airclay.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# --- what the desktop and the shell read ---------------------------------------------------------------------
install(FILES ${CMAKE_CURRENT_LIST_DIR}/airclay.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/airclay.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/airclay-mime.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages
  RENAME airclay.xml)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
# The program writes its own man page and completions, so they always match its options.
set(reference ${CMAKE_BINARY_DIR}/reference)
file(MAKE_DIRECTORY ${reference})
add_custom_command(TARGET airclay POST_BUILD COMMENT "writing the man page and the shell completions"
  COMMAND airclay reference man > ${reference}/airclay.1
  COMMAND airclay reference bash > ${reference}/airclay.bash
  COMMAND airclay reference zsh > ${reference}/airclay.zsh
  COMMAND airclay reference fish > ${reference}/airclay.fish)
install(FILES ${reference}/airclay.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${reference}/airclay.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME airclay)
install(FILES ${reference}/airclay.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _airclay)
install(FILES ${reference}/airclay.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
