# Writes ${OUT} where it changes: commit of the sources in ${DIR}, compiler and options of the build. Run with cmake -P.
set(commit "")
find_program(GIT git)
if(GIT AND EXISTS "${DIR}/.git")
  execute_process(COMMAND ${GIT} describe --always --dirty --abbrev=9 --exclude=* WORKING_DIRECTORY ${DIR} OUTPUT_VARIABLE commit
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(failed)
    set(commit "")
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#pragma once
#define MPM_BUILD_COMMIT   \"${commit}\"
#define MPM_BUILD_COMPILER \"${COMPILER}\"
#define MPM_BUILD_OPTIONS  \"${OPTIONS}\"
")
