/*
  The folder of the results, which is made where it is missing.
*/
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "io/io.h"

/* Length of the part of a path that is a folder, without the last slash; 0: none. */
static size_t FolderLength(const char path[])
{
  const char *slash = strrchr(path, '/');

  return slash ? (size_t)(slash - path) : 0;
}

/* True where the folder is there, or can be made, and takes files. */
static int CanHold(const char folder[])
{
  char        above[PETSC_MAX_PATH_LEN];
  struct stat status;

  if (!stat(*folder ? folder : ".", &status)) return S_ISDIR(status.st_mode) && !access(*folder ? folder : ".", W_OK);
  if (errno != ENOENT || strlen(folder) >= sizeof(above)) return 0;
  strcpy(above, folder);
  above[FolderLength(above)] = '\0';
  if (!*above && folder[0] == '/') strcpy(above, "/");
  return CanHold(above);
}

PetscErrorCode MpmFolderCheck(MPI_Comm comm, const char prefix[], PetscBool *there)
{
  char        folder[PETSC_MAX_PATH_LEN] = "";
  int         can                        = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscStrncpy(folder, prefix, PetscMin(FolderLength(prefix) + 1, sizeof(folder))));
  if (!rank) can = CanHold(*folder || prefix[0] != '/' ? folder : "/");
  PetscCallMPI(MPI_Bcast(&can, 1, MPI_INT, 0, comm));
  *there = can ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFolderMake(MPI_Comm comm, const char prefix[])
{
  char        folder[PETSC_MAX_PATH_LEN];
  int         failure = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (size_t end = 1; !rank && !failure && prefix[end - 1] && prefix[end]; end++) {
    if (prefix[end] != '/') continue;
    PetscCall(PetscStrncpy(folder, prefix, PetscMin(end + 1, sizeof(folder))));
    if (mkdir(folder, 0777) && errno != EEXIST) failure = errno;
  }
  PetscCall(MpmFileCheck(comm, prefix, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}
