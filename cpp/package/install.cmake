# The core as a package for CMake users: `cmake --install BUILD --component cpp --prefix WHERE`, then
# `find_package(leadthrough)` and `leadthrough::core`, or one subject, as in `leadthrough::ik`.
# `cpack` in BUILD makes a Debian package of it.
include(CMakePackageConfigHelpers)

set(package_folder lib/cmake/leadthrough)
install(TARGETS leadthrough_core ${libraries} EXPORT leadthrough
  ARCHIVE DESTINATION lib COMPONENT cpp
  LIBRARY DESTINATION lib COMPONENT cpp NAMELINK_COMPONENT cpp
  FILE_SET HEADERS DESTINATION include COMPONENT cpp)
install(EXPORT leadthrough NAMESPACE leadthrough:: FILE leadthrough-targets.cmake
  DESTINATION ${package_folder} COMPONENT cpp)

write_basic_package_version_file(leadthrough-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES package/leadthrough-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/leadthrough-config-version.cmake
  DESTINATION ${package_folder} COMPONENT cpp)

if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_GENERATOR DEB)
  set(CPACK_COMPONENTS_ALL cpp)
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_CPP_PACKAGE_NAME libleadthrough-dev)
  set(CPACK_DEBIAN_CPP_PACKAGE_DEPENDS "libeigen3-dev, liborocos-kdl-dev, liburdfdom-dev")
  set(CPACK_PACKAGE_CONTACT "the leadthrough developers")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  include(CPack)
endif()
