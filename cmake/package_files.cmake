# Files of each package that Debian wants beside the installed ones: licence, changes, compressed pages, exceptions of lintian with
# their reasons. Run by cpack before it writes the packages.
cmake_policy(SET CMP0009 NEW)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(changes "talus (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=low

  * Release ${CPACK_PACKAGE_VERSION}.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
file(READ ${CPACK_RESOURCE_FILE_LICENSE} licence)

# Exceptions: TALUS_PACKAGER is for those to set who publish the packages; a package that is not uploaded to Debian closes no bug;
# CPack writes calls of ldconfig.
set(exceptions "bogus-mail-host *" "bogus-mail-host-in-debian-changelog *" "initial-upload-closes-no-bugs *"
  "maintscript-calls-ldconfig *")

function(compress file)
  execute_process(COMMAND gzip -9 -n -f ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Scripts name Debian's Python.
function(name_interpreter file)
  file(READ ${file} text)
  string(REPLACE "#!/usr/bin/env python3" "#!/usr/bin/python3" text "${text}")
  file(WRITE ${file} "${text}")
endfunction()

file(GLOB trees ${CPACK_TEMPORARY_DIRECTORY}/*/usr)
foreach(tree ${trees})
  get_filename_component(component ${tree} DIRECTORY)
  get_filename_component(component ${component} NAME)
  string(TOUPPER ${component} component)
  set(package ${CPACK_DEBIAN_${component}_PACKAGE_NAME})
  set(documents ${tree}/share/doc/${package})
  file(WRITE ${documents}/copyright "${licence}")
  file(WRITE ${documents}/changelog.Debian "${changes}")
  compress(${documents}/changelog.Debian)
  file(REMOVE ${documents}/LICENSE)
  if(EXISTS ${documents}/CHANGELOG.md)
    file(RENAME ${documents}/CHANGELOG.md ${documents}/changelog)
    compress(${documents}/changelog)
  endif()
  foreach(exception ${exceptions})
    file(APPEND ${tree}/share/lintian/overrides/${package} "${package}: ${exception}\n")
  endforeach()
  file(GLOB pages ${tree}/share/man/man1/*.1)
  foreach(page ${pages})
    compress(${page})
  endforeach()
  file(GLOB_RECURSE scripts ${tree}/share/*.py)
  foreach(script ${scripts})
    name_interpreter(${script})
  endforeach()
endforeach()
