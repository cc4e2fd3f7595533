# cmake --install: the program, both libraries, the public headers, a CMake package, a pkg-config file, documents and examples, in the
# components program, library, development and documents.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# What who links against Talus needs by name: PETSc and MPI, for their calls are in its headers; the rest for libtalus.a.
set(TALUS_INCLUDE_DIRS ${PETSC_INCLUDE_DIRS} ${MPI_C_INCLUDE_DIRS})
set(TALUS_PUBLIC_LIBRARIES ${PETSC_LINK_LIBRARIES} ${MPI_C_LIBRARIES})
set(TALUS_PRIVATE_LIBRARIES ${HDF5_LINK_LIBRARIES} ${YAML_LINK_LIBRARIES} ${LAPACK_LIBRARIES} ${TALUS_EMBREE_LIBRARY} ${CMAKE_DL_LIBS} m)
list(FILTER TALUS_PRIVATE_LIBRARIES EXCLUDE REGEX "^-Wl|^$")
foreach(list TALUS_INCLUDE_DIRS TALUS_PUBLIC_LIBRARIES TALUS_PRIVATE_LIBRARIES)
  list(REMOVE_DUPLICATES ${list})
endforeach()
list(TRANSFORM TALUS_INCLUDE_DIRS PREPEND "-I" OUTPUT_VARIABLE TALUS_PC_INCLUDES)
string(REPLACE ";" " " TALUS_PC_INCLUDES "${TALUS_PC_INCLUDES}")
foreach(kind PUBLIC PRIVATE)
  set(words "")
  foreach(library ${TALUS_${kind}_LIBRARIES})
    if(NOT library MATCHES "[/-]")
      set(library -l${library})
    endif()
    string(APPEND words " ${library}")
  endforeach()
  string(STRIP "${words}" TALUS_PC_${kind})
endforeach()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Talus)
configure_package_config_file(cmake/TalusConfig.cmake.in ${PROJECT_BINARY_DIR}/generated/TalusConfig.cmake
  INSTALL_DESTINATION ${package} PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/TalusConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS talus RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(TARGETS talus_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(TARGETS mpm ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(DIRECTORY include/talus DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")
install(FILES ${PROJECT_BINARY_DIR}/generated/TalusConfig.cmake ${PROJECT_BINARY_DIR}/generated/TalusConfigVersion.cmake
  cmake/TalusKernels.cmake cmake/plugin.c.in DESTINATION ${package} COMPONENT development)
# The prefix is known only when it is installed to.
install(CODE "get_filename_component(CMAKE_INSTALL_PREFIX \"\${CMAKE_INSTALL_PREFIX}\" ABSOLUTE)
set(talus_source \"${PROJECT_SOURCE_DIR}\")
set(PROJECT_VERSION \"${PROJECT_VERSION}\")
set(TALUS_PC_INCLUDES \"${TALUS_PC_INCLUDES}\")
set(TALUS_PC_PUBLIC \"${TALUS_PC_PUBLIC}\")
set(TALUS_PC_PRIVATE \"${TALUS_PC_PRIVATE}\")
set(CMAKE_INSTALL_FULL_INCLUDEDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
set(CMAKE_INSTALL_FULL_LIBDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}\")
configure_file(\${talus_source}/cmake/talus.pc.in
  \"\$ENV{DESTDIR}\${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig/talus.pc\" @ONLY)" COMPONENT development)

# The manual in other forms, made from the program's own: schema of scenes, man page, completions.
find_package(Python3 COMPONENTS Interpreter QUIET)
if(Python3_Interpreter_FOUND)
  set(manual ${PROJECT_BINARY_DIR}/manual)
  file(MAKE_DIRECTORY ${manual})
  set(forms schema=talus.schema.json man=talus.1 bash=talus zsh=_talus)
  set(pages "")
  foreach(form ${forms})
    string(REGEX MATCH "^(.*)=(.*)$" unused ${form})
    set(kind ${CMAKE_MATCH_1})
    set(page ${manual}/${CMAKE_MATCH_2})
    add_custom_command(OUTPUT ${page}
      COMMAND ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0
              ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/scripts/manual.py $<TARGET_FILE:talus> ${kind} > ${page}
      DEPENDS talus ${PROJECT_SOURCE_DIR}/scripts/manual.py VERBATIM)
    list(APPEND pages ${page})
  endforeach()
  add_custom_target(manual ALL DEPENDS ${pages})
  install(FILES ${manual}/talus.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT documents)
  install(FILES ${manual}/talus DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT documents)
  install(FILES ${manual}/_talus DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT documents)
  install(FILES ${manual}/talus.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/talus COMPONENT documents)
endif()
install(DIRECTORY templates DESTINATION ${CMAKE_INSTALL_DATADIR}/talus COMPONENT documents)
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents PATTERN __pycache__ EXCLUDE)
install(FILES LICENSE README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
install(FILES scripts/maps.py scripts/results.py scripts/tables.py DESTINATION ${CMAKE_INSTALL_DATADIR}/talus/scripts COMPONENT documents)
install(PROGRAMS scripts/plot.py scripts/xdmf.py
  DESTINATION ${CMAKE_INSTALL_DATADIR}/talus/scripts COMPONENT documents)
install(DIRECTORY scripts/pictures DESTINATION ${CMAKE_INSTALL_DATADIR}/talus/scripts COMPONENT documents FILES_MATCHING PATTERN "*.py")
# The checks of the examples look for the scripts where they stand in the tree.
file(RELATIVE_PATH talus_scripts ${CMAKE_INSTALL_FULL_DOCDIR} ${CMAKE_INSTALL_FULL_DATADIR}/talus/scripts)
install(CODE "file(CREATE_LINK \"${talus_scripts}\" \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}/scripts\" SYMBOLIC)"
  COMPONENT documents)
