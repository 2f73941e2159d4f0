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
  engine/gpu/one_time.h
  engine/render/renderer_parts.h
  engine/validation/bench_peers.h
  capture/images/quiet_opencv.h
  capture/cameras/gstreamer_objects.h
  capture/cameras/gstreamer_source.h
  capture/cameras/live_feed.h
  capture/calibration/aruco_dictionary.h
  capture/calibration/calibration_parts.h
  capture/calibration/chessboard_detector.h)
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
  install(FILES ${header} DESTINATION ${AIRCLAY_INSTALL_INCLUDEDIR}/${folder})
endforeach()

# --- CMake and pkg-config ------------------------------------------------------------------------------------
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/airclay)
install(EXPORT airclay_targets NAMESPACE airclay:: FILE airclay-targets.cmake DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/airclay-config.cmake.in
  ${CMAKE_BINARY_DIR}/airclay-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/airclay-config-version.cmake COMPATIBILITY SameMinorVersion)
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
foreach(output "man:${CMAKE_INSTALL_MANDIR}/man1/airclay.1"
               "bash:${CMAKE_INSTALL_DATADIR}/bash-completion/completions/airclay"
               "zsh:${CMAKE_INSTALL_DATADIR}/zsh/site-functions/_airclay"
               "fish:${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d/airclay.fish")
  string(REPLACE ":" ";" output ${output})
  list(GET output 0 format)
  list(GET output 1 file)
  cmake_path(GET file PARENT_PATH folder)
  cmake_path(GET file FILENAME name)
  set(generated ${CMAKE_BINARY_DIR}/reference/${format})
  install(CODE "
    file(MAKE_DIRECTORY \"${generated}\")
    execute_process(COMMAND \"${CMAKE_BINARY_DIR}/airclay\" reference ${format}
      OUTPUT_FILE \"${generated}/${name}\" COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES ${generated}/${name} DESTINATION ${folder})
endforeach()
