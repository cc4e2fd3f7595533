#pragma once
/*
  JSON as a tree (RFC 8259).
*/
#include "base/base.h"

typedef enum { MPM_JSON_WORD, MPM_JSON_NUMBER, MPM_JSON_TEXT, MPM_JSON_LIST, MPM_JSON_OBJECT } MpmJsonType;

/* Words are true, false and null; `text` holds them, texts, and numbers as they are written. */
typedef struct {
  MpmJsonType type;
  PetscInt    child, next; /* first member, and the one after this; -1: none */
  const char *key, *text;
  PetscReal   number;
} MpmJsonNode;

/* Node 0 is the whole. Start from zeros. */
typedef struct {
  char        *text;
  PetscInt     count, room;
  MpmJsonNode *node;
} MpmJson;

/* Takes the text, and changes it. Returns the place of a fault in the text, or -1. */
PetscInt MpmJsonParse(char *text, MpmJson *json);
void     MpmJsonDestroy(MpmJson *json);
/* A member of an object by its key; -1: there is none. */
PetscInt MpmJsonMember(const MpmJson *json, PetscInt node, const char *key);
/* The text of a node, or NULL where it has none. */
const char *MpmJsonText(const MpmJson *json, PetscInt node);
