/*
  The program: reads options, runs the model, and turns errors into one line and an exit status.
*/
#include <ctype.h>
#include <signal.h>
#include <unistd.h>
#include "options/database.h"
#include "options/options.h"
#include "options/scene_file.h"
#include "observe/signals.h"
#include "run/command_line.h"
#include "run/law_check.h"
#include "run/pages.h"
#include "run/picture.h"
#include "run/processor.h"
#include "run/script.h"
#include "model/manual.h"
#include "model/program.h"
#include "talus/talus.h"

/* Context of the current error. */
typedef struct {
  const char *source; /* the options that are being read: whatever goes wrong is their fault */
  int         status; /* of the program, for errors that are the user's to mend; 0: a fault of the program */
  char        message[1024];
} ErrorContext;

/*
  Input errors become one line on rank 0: those of Talus, PETSc's messages about an options file, and names of unknown
  types; files that cannot be written, too. Anything else gets PETSc's traceback.
*/
static PetscErrorCode HandleError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  ErrorContext *context = (ErrorContext *)ctx;

  if (type == PETSC_ERROR_INITIAL) {
    const int   options      = !strncmp(function, "PetscOptions", 12) || code == PETSC_ERR_ARG_UNKNOWN_TYPE;
    const char *text         = message ? message : "cannot be read";
    char        culprit[256] = "";

    if (code == MPM_ERR_INPUT || options || context->source) context->status = MPM_EXIT_INPUT;
    else context->status = code == PETSC_ERR_FILE_WRITE ? MPM_EXIT_FILE : 0;
    if (context->source && code != MPM_ERR_INPUT) {
      (void)PetscSNPrintf(context->message, sizeof(context->message), "%s: %s", context->source, text);
    } else if (options && code != MPM_ERR_INPUT) {
      (void)MpmForeignOptionsFind(text, culprit, sizeof(culprit));
      (void)PetscSNPrintf(context->message, sizeof(context->message), "%s: %s", *culprit ? culprit : "PETSc's options",
                          text);
    } else (void)PetscStrncpy(context->message, text, sizeof(context->message));
  }
  if (!context->status) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, NULL);
  return code;
}

#define MESSAGE_LENGTH 400

/* Makes one line of text of a message, which quotes the user's input; its middle may be left out. */
static void MakeLine(char message[])
{
  static const char gap[]  = {' ', '.', '.', '.', ' '};
  const size_t      length = strlen(message), half = MESSAGE_LENGTH / 2;

  if (length > MESSAGE_LENGTH) {
    memcpy(&message[half], gap, sizeof(gap));
    memmove(&message[half + sizeof(gap)], &message[length - half], half + 1);
  }
  for (char *c = message; *c;) {
    unsigned  code;
    const int size = MpmDecodeUTF8((const unsigned char *)c, &code);

    if (!size) *c = '?';
    else if (iscntrl((unsigned char)*c)) *c = ' ';
    c += size ? size : 1;
  }
}

/* True where the words from this option on are kept from PetscInitialize(), which has a traceback or pages of its own
   for them. */
static int IsWithheld(const char word[])
{
  static const char *const starts[] = {"-mpm_", "-options_file", "-options_string", "-prefix_"};
  static const char *const names[]  = {"-help",  "-h",        "-version",   "-v",
                                       "--help", "--version", "-help=json", "--help=json"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(starts); i++)
    if (!strncmp(word, starts[i], strlen(starts[i]))) return 1;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(names); i++)
    if (!strcmp(word, names[i])) return 1;
  return 0;
}

/*
  PetscInitialize() would answer a bad options file with a traceback, so it is started without the options of Talus. All
  of them are read afterwards, in the order of the command line.
*/
static PetscErrorCode Initialize(int argc, char **argv, char ***words)
{
  int    count = 0, withheld = 0;
  char **kept = (char **)calloc((size_t)argc + 1, sizeof(char *));

  for (int i = 0; i < argc; i++) {
    if (argv[i][0] == '-' && (isalpha((unsigned char)argv[i][1]) || argv[i][1] == '-')) withheld = IsWithheld(argv[i]);
    if (!withheld) kept[count++] = argv[i];
  }
  *words = kept;
  return PetscInitialize(&count, words, NULL, NULL);
}

static PetscErrorCode ReadFile(const char option[], const char path[], PetscBool yaml, MpmSources sources,
                               ErrorContext *context)
{
  char      source[PETSC_MAX_PATH_LEN + 32];
  PetscBool readable;

  PetscFunctionBeginUser;
  PetscCall(PetscTestFile(path, 'r', &readable));
  MpmCheckInput(readable, "%s %s: the file cannot be read", option, path);
  PetscCall(MpmOptionsCheckFile(PETSC_COMM_WORLD, option, path, yaml));
  PetscCall(PetscSNPrintf(source, sizeof(source), "%s %s", option, path));
  context->source = source;
  PetscCall(MpmSourcesInsertFile(sources, PETSC_COMM_WORLD, NULL, path, yaml));
  context->source = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a file that is named as the scene and has nothing of one. */
static PetscErrorCode CheckScene(const char path[])
{
  char     *all;
  PetscBool scene;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetAll(NULL, &all));
  scene = (PetscBool)(strstr(all, "-mpm_") != NULL);
  PetscCall(PetscFree(all));
  MpmCheckInput(scene, "%s has no block mpm: a scene's options stand below `mpm:`", path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the files, in their order, and then the remaining command line, which overrides them. */
static PetscErrorCode ReadOptions(const MpmCommandLine *line, MpmSources sources, ErrorContext *context)
{
  const int    argc  = line->count;
  char **const argv  = line->words;
  int          count = 1, again;
  char       **rest;
  PetscBool    log;
  PetscOptions alone;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((size_t)argc + 1, &rest));
  rest[0] = argv[0];
  for (int i = 1; i < argc; i++) {
    const PetscBool yaml = (PetscBool)!strcmp(argv[i], "-options_file_yaml");

    MpmCheckInput(strncmp(argv[i], "-prefix_p", 9), "%s: prefixes are not available on the command line", argv[i]);
    if (!yaml && strcmp(argv[i], "-options_file")) {
      rest[count++] = argv[i];
      continue;
    }
    MpmCheckInput(i + 1 < argc, "%s is the last word of the command line: a file must follow", argv[i]);
    PetscCall(ReadFile(argv[i], argv[i + 1], yaml, sources, context));
    if (i == 1 && line->scenes) PetscCall(CheckScene(argv[2]));
    i++;
  }
  context->source = "command line";
  again           = count;
  PetscCall(PetscOptionsInsert(NULL, &count, &rest, NULL));
  PetscCall(PetscOptionsCreate(&alone));
  PetscCall(PetscOptionsInsertArgs(alone, again - 1, &rest[1]));
  PetscCall(MpmSourcesAdd(sources, NULL, alone));
  PetscCall(PetscOptionsDestroy(&alone));
  context->source = NULL;
  PetscCall(PetscFree(rest));
  /* an option file may request the log that PetscInitialize() would have started */
  PetscCall(PetscOptionsHasName(NULL, NULL, "-log_view", &log));
  if (log) PetscCall(PetscLogDefaultBegin());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options for information instead of a run; PETSC_FALSE where there are none. */
static PetscErrorCode AnswerQuestions(const MpmCommandLine *line, int *status, PetscBool *answered)
{
  char     *all;
  PetscBool set;

  PetscFunctionBeginUser;
  *answered = PETSC_TRUE;
  if (line->task > MPM_TASK_CHECK) PetscFunctionReturn(MpmPagePrint(PETSC_COMM_WORLD, line));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-help_petsc", &set));
  if (set) {
    PetscCall(MpmHelpPetsc(PETSC_COMM_WORLD));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscOptionsGetAll(NULL, &all));
  *answered = (PetscBool)(line->count == 1 && !all[0]);
  PetscCall(PetscFree(all));
  if (*answered) {
    PetscCall(MpmHelpUsage(PETSC_COMM_WORLD, stderr));
    *status = MPM_EXIT_INPUT;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MpmCommandLine *line, ErrorContext *context, int *status)
{
  MpmModel   model;
  MpmSources sources;
  PetscBool  answered, help = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MpmSourcesCreate(&sources));
  PetscCall(MpmStandardInputKeep(PETSC_COMM_WORLD, line));
  PetscCall(ReadOptions(line, sources, context));
  PetscCall(AnswerQuestions(line, status, &answered));
  if (answered) PetscFunctionReturn(MpmSourcesDestroy(&sources));
  help = MpmOptionsHelp();
  if (help) PetscCall(MpmHelpBegin(PETSC_COMM_WORLD));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(MpmModelUseTerminal(model));
  MpmModelSetSources(model, sources);
  PetscCall(MpmModelSetFromOptions(model));
  if (help) {
    PetscCall(MpmHelpEnd(PETSC_COMM_WORLD));
    PetscCall(PetscOptionsClearValue(NULL, "-help")); /* else PETSc goes on with its own when it ends */
    PetscCall(PetscOptionsClearValue(NULL, "-h"));
  }
  if (!help) {
    if (line->picture) PetscCall(MpmPictureDraw(PETSC_COMM_WORLD, model, line->picture));
    PetscCall(MpmSignalsCatch());
    if (line->task == MPM_TASK_CHECK) PetscCall(MpmModelCheck(model, status));
    else PetscCall(MpmModelRun(model, status));
    PetscCall(MpmSignalsRelease());
  }
  PetscCall(MpmModelDestroy(&model));
  PetscCall(MpmSourcesDestroy(&sources));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The end after a file that could not be written. HDF5 cannot close such a file: it tries once more when MPI ends, and
  crashes. The program therefore ends without either, once all ranks are here.
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
  const char    *lacks   = MpmProcessorLacks(mpm_compiled_with);
  ErrorContext   context = {NULL, 0, ""};
  MpmCommandLine line;
  int            status = 0;
  char         **words  = NULL;
  PetscErrorCode error;

  if (lacks) {
    (void)fprintf(
      stderr, "talus: error: compiled for a processor with %s, which this one lacks; build with -DTALUS_NATIVE=OFF\n",
      lacks);
    return 1;
  }
  if (MpmLawCheckNamed(argc, argv)) return MpmLawCheckRun(argc, argv);
  if (MpmScriptNamed(argc, argv)) return MpmScriptRun(argc, argv);
  if (MpmCommandLineRead(argc, argv, &line) || Initialize(line.count, line.words, &words)) return 1;
  (void)signal(SIGPIPE, SIG_DFL); /* who reads the output through `head` has seen enough: no traceback */
  PetscCall(PetscPushErrorHandler(HandleError, &context));
  error = Run(&line, &context, &status);
  MpmStandardInputRemove(&line);
  if (error && context.status) {
    MakeLine(context.message);
    (void)PetscFPrintf(PETSC_COMM_WORLD, stderr, "talus: error: %s\n", context.message);
    status = context.status;
    if (status == MPM_EXIT_FILE) EndAtOnce(status);
    (void)PetscOptionsClearValue(NULL, "-options_left"); /* many, in a scene that was not read to its end */
  } else if (error) {
    MPI_Abort(PETSC_COMM_WORLD, 1);
  }
  PetscCall(PetscPopErrorHandler());
  PetscCall(PetscFinalize());
  free(words);
  MpmCommandLineFree(&line);
  return status;
}
