# phistep_cpack: `cpack` makes a Debian package and an archive of what `cmake --install` installs.

set(CPACK_GENERATOR "DEB;TGZ")
set(CPACK_PACKAGE_NAME phistep)
set(CPACK_PACKAGE_VENDOR "phistep contributors")
set(CPACK_PACKAGE_CONTACT "phistep contributors <phistep@localhost>")  # Debian asks for an address
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION "A C++20 header-only library that steps vectors of Eigen, and motion, in time: explicit and
implicit schemes, events, checkpoints, many particles.")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_PACKAGE_FILE_NAME "phistep-${PROJECT_VERSION}-install")  # not the name of the archive of the sources
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)             # phistep_0.2.0_all.deb
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE all)          # headers only
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "g++ (>= 4:12), cmake (>= 3.22), pkg-config")
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
