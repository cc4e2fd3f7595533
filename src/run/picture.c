/*
  The picture of a scene before any run: its first state goes to a folder of its own, from which the script draws it.
*/
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include "base/base.h"
#include "model/program.h"
#include "run/picture.h"
#include "run/script.h"

/* Removes a folder and its files. */
static void RemoveFolder(const char folder[])
{
  DIR           *open = opendir(folder);
  struct dirent *entry;
  char           path[PETSC_MAX_PATH_LEN];

  while (open && (entry = readdir(open)))
    if (snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name) < (int)sizeof(path)) (void)unlink(path);
  if (open) (void)closedir(open);
  (void)rmdir(folder);
}

PetscErrorCode MpmPictureDraw(MPI_Comm comm, MpmModel model, const char picture[])
{
  const char *place = getenv("TMPDIR");
  char        folder[PETSC_MAX_PATH_LEN - 64], prefix[PETSC_MAX_PATH_LEN];
  int         failure = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  MpmCheckInput(picture[0], "--picture: a file must follow");
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscSNPrintf(folder, sizeof(folder), "%s/talus-picture-XXXXXX", place && *place ? place : "/tmp"));
  if (!rank) failure = !mkdtemp(folder);
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  MpmCheckInput(!failure, "--picture: no folder can be made in %s", place && *place ? place : "/tmp");
  PetscCallMPI(MPI_Bcast(folder, sizeof(folder), MPI_CHAR, 0, comm));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "%s/start", folder));
  PetscCall(MpmModelWriteStart(model, prefix));
  if (!rank) {
    failure = MpmScriptDraw(prefix, picture);
    RemoveFolder(folder);
  }
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  MpmCheckInput(!failure, "--picture %s: not drawn", picture);
  PetscFunctionReturn(PETSC_SUCCESS);
}
