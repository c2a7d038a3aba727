# The core as a package for CMake users: `cmake --install BUILD --component cpp --prefix WHERE`, then
# `find_package(leadthrough)` and `leadthrough::core`, or one subject, as in `leadthrough::ik`.
include(CMakePackageConfigHelpers)

set(package_folder lib/cmake/leadthrough)
set(targets leadthrough_core leadthrough_flags ${libraries})
set_target_properties(leadthrough_core PROPERTIES EXPORT_NAME core)
set_target_properties(leadthrough_flags PROPERTIES EXPORT_NAME flags)

install(TARGETS ${targets} EXPORT leadthrough ARCHIVE DESTINATION lib COMPONENT cpp)
install(EXPORT leadthrough NAMESPACE leadthrough:: FILE leadthrough-targets.cmake
  DESTINATION ${package_folder} COMPONENT cpp)
install(DIRECTORY leadthrough DESTINATION include COMPONENT cpp
  FILES_MATCHING PATTERN "*.hpp")

write_basic_package_version_file(leadthrough-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES package/leadthrough-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/leadthrough-config-version.cmake
  DESTINATION ${package_folder} COMPONENT cpp)
