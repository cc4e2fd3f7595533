/*
  Pages in place of a run: parts of the manual, the manual as data, the version.
*/
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include "model/manual.h"
#include "mpm_build.h"
#include "run/pages.h"
#include "run/templates.h"
#include "talus/talus.h"

#define PAGE_LINES 50 /* a text of more goes through a pager */

/* Prints on rank 0; a long text on a terminal goes through the user's pager. */
static PetscErrorCode PrintText(MPI_Comm comm, const char text[])
{
  const char *pager = getenv("PAGER");
  int         lines = 0;
  PetscMPIInt rank, size;
  FILE       *pipe = NULL;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  for (const char *c = text; *c; c++) lines += *c == '\n';
  if (size == 1 && lines > PAGE_LINES && isatty(STDOUT_FILENO))
    pipe = popen(pager && *pager ? pager : "less -FRX", "w");
  (void)fputs(text, pipe ? pipe : stdout);
  if (pipe) (void)pclose(pipe);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendHeading(MpmCatalogue catalogue, PetscInt section, char **text)
{
  PetscFunctionBegin;
  PetscCall(MpmTextAppend(text, "%s%s\n", *text ? "\n" : "", catalogue->sections[section]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends items chosen, under the headings of their sections. */
static PetscErrorCode AppendChosen(MpmCatalogue catalogue, const PetscBool chosen[], char **text)
{
  PetscFunctionBegin;
  for (PetscInt s = 0; s < catalogue->section_count; s++) {
    PetscBool headed = PETSC_FALSE;

    for (PetscInt i = 0; i < catalogue->item_count; i++) {
      if (!chosen[i] || catalogue->items[i].section != s) continue;
      if (!headed) PetscCall(AppendHeading(catalogue, s, text));
      headed = PETSC_TRUE;
      PetscCall(MpmCatalogueItemText(&catalogue->items[i], text));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the text contains the word, case aside. */
static PetscBool Contains(const char text[], const char word[])
{
  const size_t length = strlen(word);

  for (; *text; text++)
    if (!strncasecmp(text, word, length)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where the heading is the topic, or its plural. */
static PetscBool Names(const char heading[], const char topic[])
{
  const size_t length = strlen(topic);

  if (strncasecmp(heading, topic, length)) return PETSC_FALSE;
  return (PetscBool)(!heading[length] || !strcasecmp(&heading[length], "s") || heading[length] == ',');
}

/* Ways to find options by a topic, the first that finds any counts. */
static PetscBool Concerns(MpmCatalogue catalogue, const MpmCatalogueItem *item, const char topic[], PetscInt way)
{
  const char *heading = catalogue->sections[item->section];

  switch (way) {
  case 0:
    return MpmCatalogueItemIs(item, topic[0] == '-' ? &topic[1] : topic);
  case 1:
    return Names(heading, topic);
  case 2:
    return Contains(heading, topic);
  default:
    return Contains(item->name, topic[0] == '-' ? &topic[1] : topic);
  }
}

/* The topic in the words of the headings. */
static const char *HeadingOf(const char topic[])
{
  static const char *const words[][2] = {{"bc", "condition"},
                                         {"bcs", "condition"},
                                         {"law", "material of type"},
                                         {"laws", "material of type"},
                                         {"contact", "contact of bodies"},
                                         {"stress_point", "point"},
                                         {"laboratory", "point"},
                                         {"results", "output"}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(words); k++)
    if (!strcasecmp(topic, words[k][0])) return words[k][1];
  return topic;
}

static PetscErrorCode AppendTopic(MpmCatalogue catalogue, const char topic[], char **text)
{
  PetscBool *chosen, found = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(catalogue->item_count, &chosen));
  for (PetscInt way = 0; way < 4 && !found; way++) {
    for (PetscInt i = 0; i < catalogue->item_count; i++) {
      chosen[i] = Concerns(catalogue, &catalogue->items[i], HeadingOf(topic), way);
      found     = (PetscBool)(found || chosen[i]);
    }
  }
  MpmCheckInput(found, "help %s: no such topic or option; `talus help` lists the topics", topic);
  PetscCall(AppendChosen(catalogue, chosen, text));
  PetscCall(PetscFree(chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendTopics(MpmCatalogue catalogue, char **text)
{
  PetscFunctionBegin;
  PetscCall(MpmTextAppend(text,
                          "talus help TOPIC prints a part of the manual: TOPIC is a heading below, a word of one, "
                          "or part of an option's\nname. talus help -mpm_option prints one option.\n\n"));
  for (PetscInt s = 0; s < catalogue->section_count; s++)
    PetscCall(MpmTextAppend(text, "  %s\n", catalogue->sections[s]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintManual(MPI_Comm comm, const MpmCommandLine *line)
{
  MpmCatalogue catalogue;
  MpmTextFile  json = MPM_TEXT_FILE_EMPTY;
  char        *text = NULL;

  PetscFunctionBegin;
  PetscCall(MpmCatalogueCreate(&catalogue));
  PetscCall(MpmHelpCollect(comm, catalogue));
  if (line->task == MPM_TASK_JSON) {
    PetscCall(MpmCatalogueJSON(catalogue, &json));
    PetscCall(PrintText(comm, json.data));
    PetscCall(MpmTextFileDestroy(&json));
  } else {
    if (line->topic) PetscCall(AppendTopic(catalogue, line->topic, &text));
    else PetscCall(AppendTopics(catalogue, &text));
    PetscCall(PrintText(comm, text));
    PetscCall(PetscFree(text));
  }
  PetscCall(MpmCatalogueDestroy(&catalogue));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintVersion(MPI_Comm comm)
{
  char petsc[256];

  PetscFunctionBegin;
  PetscCall(PetscGetVersion(petsc, sizeof(petsc)));
  PetscCall(PetscPrintf(comm, "talus %s%s%s\n%s\ncompiled by %s, %s\n", MPM_VERSION,
                        MPM_BUILD_COMMIT[0] ? ", commit " : "", MPM_BUILD_COMMIT, petsc, MPM_BUILD_COMPILER,
                        MPM_BUILD_OPTIONS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPagePrint(MPI_Comm comm, const MpmCommandLine *line)
{
  PetscFunctionBegin;
  switch (line->task) {
  case MPM_TASK_HELP:
    PetscCall(MpmHelpShort(comm));
    break;
  case MPM_TASK_VERSION:
    PetscCall(PrintVersion(comm));
    break;
  case MPM_TASK_NEW:
    PetscCall(MpmTemplateWrite(comm, line));
    break;
  default:
    PetscCall(PrintManual(comm, line));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
