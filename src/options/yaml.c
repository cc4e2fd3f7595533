/*
  Errors of YAML in a scene, and options that stand in it twice: PETSc would silently take the last one. libyaml reads
  the file as for PETSc.

  Keys on the path to a value make the option's name, joined by underscores, upper and lower case alike: `a: {b: 1}` and
  `a_b: 1` are one option. Entries of a merge key (<<) may be overridden; keys with $$ are no options.
*/
#include "options/scene_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <yaml.h>

#define MOST_OPTIONS 10000 /* of a file; with aliases a few lines could give any number */
#define DEEPEST      100   /* an alias may stand in its own anchor */

typedef struct {
  char  *name;
  size_t line;
} Leaf;

typedef struct {
  yaml_document_t *document;
  Leaf            *leaves; /* room for MOST_OPTIONS */
  PetscInt         count;
  char            *fault; /* the buffer for it; empty for none */
  size_t           size;
} Walk;

static const char *Text(const yaml_node_t *node)
{
  return (const char *)node->data.scalar.value;
}

static size_t Line(const yaml_node_t *node)
{
  return node->start_mark.line + 1;
}

static void Fault(Walk *walk, size_t line, const char what[], const char name[])
{
  if (!*walk->fault) (void)snprintf(walk->fault, walk->size, "line %zu %s%.120s", line, what, name);
}

static void FaultTwice(Walk *walk, const char name[], size_t first, size_t second)
{
  if (!*walk->fault) {
    (void)snprintf(walk->fault, walk->size,
                   "line %zu: %.120s stands here for the second time, the first is in line %zu",
                   PetscMax(first, second), name, PetscMin(first, second));
  }
}

/* True where the key is an option's. */
static PetscBool IsPlainKey(const yaml_node_t *key)
{
  return (PetscBool)(key->type == YAML_SCALAR_NODE && strcmp(Text(key), "<<") && strncmp(Text(key), "$$", 2));
}

static PetscErrorCode WalkMapping(Walk *walk, const char prefix[], const yaml_node_t *mapping, PetscInt depth);

/* Visits the value of a key. Sequences are values, and options where their entries are mappings. */
static PetscErrorCode WalkValue(Walk *walk, const char name[], const yaml_node_t *key, const yaml_node_t *value,
                                PetscInt depth)
{
  char *inner = NULL;

  PetscFunctionBegin;
  if (depth > DEEPEST) Fault(walk, Line(key), "is nested more than 100 deep", "");
  if (walk->count == MOST_OPTIONS) Fault(walk, Line(key), "is one option too many: a file may give 10000", "");
  if (*walk->fault) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextAppend(&inner, "%s_", name));
  if (value->type == YAML_MAPPING_NODE) PetscCall(WalkMapping(walk, inner, value, depth + 1));
  else {
    walk->leaves[walk->count].line = Line(key);
    PetscCall(PetscStrallocpy(name, &walk->leaves[walk->count++].name));
  }
  for (yaml_node_item_t *item = value->data.sequence.items.start;
       value->type == YAML_SEQUENCE_NODE && item < value->data.sequence.items.top; item++) {
    const yaml_node_t *entry = yaml_document_get_node(walk->document, *item);

    if (entry->type == YAML_MAPPING_NODE) PetscCall(WalkMapping(walk, inner, entry, depth + 1));
  }
  PetscCall(PetscFree(inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WalkMapping(Walk *walk, const char prefix[], const yaml_node_t *mapping, PetscInt depth)
{
  const yaml_node_pair_t *begin = mapping->data.mapping.pairs.start, *end = mapping->data.mapping.pairs.top;

  PetscFunctionBegin;
  for (const yaml_node_pair_t *pair = begin; pair < end && !*walk->fault; pair++) {
    const yaml_node_t *key  = yaml_document_get_node(walk->document, pair->key);
    char              *name = NULL;

    if (!IsPlainKey(key)) continue;
    PetscCall(MpmTextAppend(&name, "%s%s", prefix, Text(key)));
    for (const yaml_node_pair_t *before = begin; before < pair; before++) {
      const yaml_node_t *other = yaml_document_get_node(walk->document, before->key);

      if (IsPlainKey(other) && !strcasecmp(Text(other), Text(key))) FaultTwice(walk, name, Line(other), Line(key));
    }
    PetscCall(WalkValue(walk, name, key, yaml_document_get_node(walk->document, pair->value), depth));
    PetscCall(PetscFree(name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareLeaves(const void *a, const void *b)
{
  return strcasecmp(((const Leaf *)a)->name, ((const Leaf *)b)->name);
}

static PetscErrorCode CheckDocument(Walk *walk)
{
  const yaml_node_t *root = yaml_document_get_root_node(walk->document);

  PetscFunctionBegin;
  walk->count = 0;
  if (root->type == YAML_MAPPING_NODE) PetscCall(WalkMapping(walk, "", root, 0));
  if (walk->count) qsort(walk->leaves, (size_t)walk->count, sizeof(Leaf), CompareLeaves);
  for (PetscInt i = 1; i < walk->count; i++) {
    const Leaf *one = &walk->leaves[i - 1], *two = &walk->leaves[i];

    if (!CompareLeaves(one, two)) FaultTwice(walk, one->name, one->line, two->line);
  }
  for (PetscInt i = 0; i < walk->count; i++) PetscCall(PetscFree(walk->leaves[i].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmYAMLCheck(const char path[], char fault[], size_t size)
{
  yaml_document_t document;
  yaml_parser_t   parser;
  Walk            walk = {.document = &document, .fault = fault, .size = size};
  PetscBool       more = PETSC_TRUE;
  FILE           *file = fopen(path, "r");

  PetscFunctionBegin;
  fault[0] = '\0';
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(yaml_parser_initialize(&parser), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the YAML parser");
  yaml_parser_set_input_file(&parser, file);
  PetscCall(PetscMalloc1(MOST_OPTIONS, &walk.leaves));
  while (more && !*fault) {
    if (!yaml_parser_load(&parser, &document)) {
      Fault(&walk, parser.problem_mark.line + 1, "is no YAML: ", parser.problem ? parser.problem : "it cannot be read");
      break;
    }
    more = (PetscBool)(yaml_document_get_root_node(&document) != NULL);
    if (more) PetscCall(CheckDocument(&walk));
    yaml_document_delete(&document);
  }
  PetscCall(PetscFree(walk.leaves));
  yaml_parser_delete(&parser);
  fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}
