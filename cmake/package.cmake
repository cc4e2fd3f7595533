# cpack -G DEB in the build folder: Debian packages of the program, the shared library and what developers need. Packages for
# others are made by scripts/package.sh, from a build for any processor.
set(TALUS_PACKAGER "Talus developers <talus@localhost.localdomain>" CACHE STRING "maintainer of packages, NAME <ADDRESS>")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME talus)
set(CPACK_PACKAGE_CONTACT "${TALUS_PACKAGER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "implicit material point method for geomechanics")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_SET_DESTDIR ON) # the prefix stands in the pkg-config file
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${TALUS_PACKAGER}")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(TALUS_LIBRARY_PACKAGE libtalus${TALUS_SOVERSION})
set(CPACK_DEBIAN_TALUS_PACKAGE_NAME talus)
set(CPACK_DEBIAN_TALUS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TALUS_PACKAGE_DEPENDS python3)
set(CPACK_DEBIAN_TALUS_PACKAGE_RECOMMENDS "openmpi-bin, python3-h5py, python3-matplotlib, python3-numpy, python3-yaml")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${TALUS_LIBRARY_PACKAGE})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(debian ${PROJECT_BINARY_DIR}/generated/debian)
file(WRITE ${debian}/triggers "activate-noawait ldconfig\n")
file(WRITE ${debian}/shlibs "libtalus ${TALUS_SOVERSION} ${TALUS_LIBRARY_PACKAGE} (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${debian}/triggers ${debian}/shlibs)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libtalus-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "${TALUS_LIBRARY_PACKAGE} (= ${PROJECT_VERSION}-1), petsc-dev, libhdf5-openmpi-dev, liblapack-dev, libyaml-dev")
if(TALUS_EMBREE)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libembree-dev")
endif()
set(about "Talus computes large deformations of soils, structures and other solids:
quasi-static, dynamic and explicit steps, consolidation, contact, strength
reduction, in plane strain, with axial symmetry and in 3D, on any number of
processes.

This package has")
set(CPACK_DEBIAN_TALUS_DESCRIPTION "${about} the program, its documents and examples.")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "${about} the library that other programs use.")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "${about} what programs and plugins are compiled against.")

set(CPACK_COMPONENTS_ALL program documents library development)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package_files.cmake)
include(CPack)
cpack_add_component_group(talus)
cpack_add_component_group(library)
cpack_add_component_group(development)
cpack_add_component(program GROUP talus)
cpack_add_component(documents GROUP talus)
cpack_add_component(library GROUP library)
cpack_add_component(development GROUP development)
