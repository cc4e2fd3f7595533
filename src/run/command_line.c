/*
  The words of the command line, before PETSc reads them.
*/
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "run/command_line.h"

static const char option_file[] = "-options_file";

/* The task that a first word stands for. */
static MpmTask FirstTask(const char word[])
{
  static const struct {
    const char *word;
    MpmTask     task;
  } tasks[] = {{"help", MPM_TASK_TOPIC}, {"check", MPM_TASK_CHECK}, {"new", MPM_TASK_NEW}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(tasks); k++)
    if (!strcmp(word, tasks[k].word)) return tasks[k].task;
  return MPM_TASK_RUN;
}

/* True where this word asks for a page in place of a run. */
static int FindTask(const char word[], MpmTask *task)
{
  static const struct {
    const char *word;
    MpmTask     task;
  } pages[] = {{"--help", MPM_TASK_HELP},      {"-h", MPM_TASK_HELP},         {"--version", MPM_TASK_VERSION},
               {"-version", MPM_TASK_VERSION}, {"-help=json", MPM_TASK_JSON}, {"--help=json", MPM_TASK_JSON}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(pages); k++)
    if (!strcmp(word, pages[k].word)) {
      *task = pages[k].task;
      return 1;
    }
  return 0;
}

int MpmCommandLineRead(int argc, char **argv, MpmCommandLine *line)
{
  int           next = 1, scenes = 1;
  const MpmTask task = argc > 1 ? FirstTask(argv[1]) : MPM_TASK_RUN;
  const int     page = task == MPM_TASK_TOPIC || task == MPM_TASK_NEW;

  *line       = (MpmCommandLine){.task = task, .count = 1};
  line->words = (char **)calloc(2 * (size_t)argc + 2, sizeof(char *));
  if (!line->words) return 1;
  line->words[0] = argv[0];
  if (task != MPM_TASK_RUN) next = 2;
  if (page && next < argc) line->topic = argv[next++];
  if (task == MPM_TASK_NEW && next < argc) line->file = argv[next++];
  for (int i = next; i < argc; i++) {
    if (task == MPM_TASK_CHECK && !strcmp(argv[i], "--picture")) {
      line->picture = i + 1 < argc ? argv[++i] : "";
      continue;
    }
    if (argv[i][0] == '-' && argv[i][1]) scenes = 0;
    if (!page && FindTask(argv[i], &line->task)) continue;
    if (scenes && task != MPM_TASK_NEW) {
      line->words[line->count++] = (char *)option_file;
      line->scenes++;
    }
    line->words[line->count++] = argv[i];
  }
  return 0;
}

void MpmCommandLineFree(MpmCommandLine *line)
{
  free(line->words);
  line->words = NULL;
}

/* Copies stdin to a new file; 0 or errno. */
static int CopyInput(char path[])
{
  char   buffer[1 << 16];
  size_t length;
  int    failure, handle = mkstemps(path, 5);
  FILE  *file = handle < 0 ? NULL : fdopen(handle, "w");

  if (!file) return errno;
  while ((length = fread(buffer, 1, sizeof(buffer), stdin)) > 0)
    if (fwrite(buffer, 1, length, file) != length) break;
  failure = ferror(file) || ferror(stdin) ? EIO : 0;
  return fclose(file) && !failure ? errno : failure;
}

PetscErrorCode MpmStandardInputKeep(MPI_Comm comm, MpmCommandLine *line)
{
  const char *folder  = getenv("TMPDIR");
  int         failure = 0, word = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  for (int i = 1; i < line->count && !word; i++)
    if (!strcmp(line->words[i], "-") && !strcmp(line->words[i - 1], option_file)) word = i;
  if (!word) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscSNPrintf(line->input, sizeof(line->input), "%s/talus-stdin-XXXXXX.yaml", folder && *folder ? folder : "/tmp"));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    failure          = CopyInput(line->input);
    line->owns_input = 1;
  }
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  MpmCheckInput(!failure, "-: standard input cannot be read: %s", strerror(failure));
  PetscCallMPI(MPI_Bcast(line->input, sizeof(line->input), MPI_CHAR, 0, comm));
  line->words[word] = line->input;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmStandardInputRemove(MpmCommandLine *line)
{
  if (line->owns_input) (void)unlink(line->input);
  line->owns_input = 0;
}
