/*
  The program: reads options, runs the model, and turns errors into one line and an exit status.
*/
#include <unistd.h>
#include "mpm.h"

static char help[] = "Talus: implicit material point method for soils, rocks, snow and structures.\n"
                     "  mpiexec -n N talus -options_file scene.yaml [any -mpm_ option] [any PETSc option]\n\n";

PetscErrorCode MpmLawsPrintHelp(MPI_Comm comm);

/* What the handler knows of the current error. */
typedef struct {
  const char *file;   /* the options file that is being read: whatever goes wrong is its fault */
  int         status; /* of the program, for errors that are the user's to mend; 0: a fault of the program */
  char        message[1024];
} ErrorContext;

/*
  Input errors become one line on rank 0: ours, what PETSc says of an options file, and names of types that it does not
  know. So do files that cannot be written. Anything else gets PETSc's traceback.
*/
static PetscErrorCode HandleError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  ErrorContext *context = (ErrorContext *)ctx;

  if (type == PETSC_ERROR_INITIAL) {
    if (code == MPM_ERR_INPUT || code == PETSC_ERR_ARG_UNKNOWN_TYPE || context->file) context->status = MPM_EXIT_INPUT;
    else context->status = code == PETSC_ERR_FILE_WRITE ? MPM_EXIT_FILE : 0;
    if (context->file) {
      (void)PetscSNPrintf(context->message, sizeof(context->message), "-options_file %s: %s", context->file,
                          message ? message : "cannot be read");
    } else if (message) (void)PetscStrncpy(context->message, message, sizeof(context->message));
  }
  if (!context->status) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, NULL);
  return code;
}

/*
  PetscInitialize() would answer a bad options file with a traceback, so it is started without files; they are read
  afterwards, in the order of the command line.
*/
static PetscErrorCode Initialize(int *argc, char ***argv, char ***without_files)
{
  int    count = 0;
  char **kept  = (char **)calloc((size_t)*argc + 1, sizeof(char *));

  for (int i = 0; i < *argc; i++) {
    if (!strcmp((*argv)[i], "-options_file") || !strcmp((*argv)[i], "-options_file_yaml")) i++;
    else kept[count++] = (*argv)[i];
  }
  *without_files = kept;
  return PetscInitialize(&count, without_files, NULL, help);
}

/* Reads the files, in their order, and then the rest of the command line, which overrides them. */
static PetscErrorCode ReadOptions(int argc, char **argv, char **without_files, ErrorContext *context)
{
  int       count = 0;
  PetscBool log;

  PetscFunctionBeginUser;
  for (int i = 1; i < argc; i++) {
    const PetscBool yaml = (PetscBool)!strcmp(argv[i], "-options_file_yaml");
    PetscBool       readable;

    if (!yaml && strcmp(argv[i], "-options_file")) continue;
    MpmCheckInput(i + 1 < argc, "%s is the last word of the command line: a file must follow", argv[i]);
    PetscCall(PetscTestFile(argv[i + 1], 'r', &readable));
    MpmCheckInput(readable, "%s %s: the file cannot be read", argv[i], argv[i + 1]);
    context->file = argv[i + 1];
    if (yaml) PetscCall(PetscOptionsInsertFileYAML(PETSC_COMM_WORLD, NULL, argv[i + 1], PETSC_TRUE));
    else PetscCall(PetscOptionsInsertFile(PETSC_COMM_WORLD, NULL, argv[i + 1], PETSC_TRUE));
    context->file = NULL;
  }
  while (without_files[count]) count++;
  PetscCall(PetscOptionsInsert(NULL, &count, &without_files, NULL));
  /* an option file may ask for the log that PetscInitialize() would have started */
  PetscCall(PetscOptionsHasName(NULL, NULL, "-log_view", &log));
  if (log) PetscCall(PetscLogDefaultBegin());
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(int argc, char **argv, char **without_files, ErrorContext *context, int *status)
{
  MpmModel  model;
  PetscBool wants_help;

  PetscFunctionBeginUser;
  PetscCall(ReadOptions(argc, argv, without_files, context));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(MpmModelSetFromOptions(model));
  wants_help = MpmOptionsHelp();
  if (wants_help) PetscCall(MpmLawsPrintHelp(PETSC_COMM_WORLD));
  else PetscCall(MpmModelRun(model, status));
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The end after a file that could not be written. HDF5 cannot let go of such a file: it tries once more when MPI ends, and
  crashes. So the program ends without either, once all ranks are here.
*/
static void EndAtOnce(int status)
{
  PetscMPIInt size;

  (void)fflush(NULL);
  (void)MPI_Comm_size(PETSC_COMM_WORLD, &size);
  (void)MPI_Barrier(PETSC_COMM_WORLD);
  if (size > 1) (void)MPI_Abort(PETSC_COMM_WORLD, status);
  _exit(status);
}

int main(int argc, char **argv)
{
  ErrorContext   context   = {NULL, 0, ""};
  int            status    = 0;
  char         **arguments = NULL;
  PetscErrorCode error;

  if (Initialize(&argc, &argv, &arguments)) return 1;
  PetscCall(PetscPushErrorHandler(HandleError, &context));
  error = Run(argc, argv, arguments, &context, &status);
  if (error && context.status) {
    (void)PetscFPrintf(PETSC_COMM_WORLD, stderr, "talus: error: %s\n", context.message);
    status = context.status;
    if (status == MPM_EXIT_FILE) EndAtOnce(status);
  } else if (error) {
    MPI_Abort(PETSC_COMM_WORLD, 1);
  }
  PetscCall(PetscPopErrorHandler());
  PetscCall(PetscFinalize());
  free(arguments);
  return status;
}
