/*
  JSON as a tree, by recursive descent. Texts are unescaped where they stand.
*/
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include "maps/json.h"

#define DEEPEST 200

typedef struct {
  MpmJson *json;
  char    *at;
  int      depth;
} Reader;

static PetscInt ReadValue(Reader *reader);

static void Skip(Reader *reader)
{
  reader->at += strspn(reader->at, " \t\r\n");
}

/* A new node; -1 without memory. */
static PetscInt Add(MpmJson *json, MpmJsonType type)
{
  if (json->count == json->room) {
    const PetscInt room = 2 * json->room + 64;
    MpmJsonNode   *node = realloc(json->node, (size_t)room * sizeof(*node));

    if (!node) return -1;
    json->node = node;
    json->room = room;
  }
  json->node[json->count] = (MpmJsonNode){.type = type, .child = -1, .next = -1};
  return json->count++;
}

/* Four hexadecimal digits; -1: they are none. */
static long Code(const char *at)
{
  char digits[5] = "";

  for (int k = 0; k < 4; k++) {
    if (!isxdigit((unsigned char)at[k])) return -1;
    digits[k] = at[k];
  }
  return strtol(digits, NULL, 16);
}

/* A character as UTF-8. */
static char *Put(char *to, long code)
{
  const int bytes = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4, head[] = {0, 0, 0xc0, 0xe0, 0xf0};

  for (int k = bytes - 1; k > 0; k--, code >>= 6) to[k] = (char)(0x80 | (code & 0x3f));
  to[0] = (char)(head[bytes] | code);
  return to + bytes;
}

/* The text after a quote; NULL: it has a fault. */
static const char *ReadText(Reader *reader)
{
  static const char from[] = "\"\\/bfnrt", into[] = "\"\\/\b\f\n\r\t";
  char             *text = reader->at, *to = text;

  for (; *reader->at && *reader->at != '"'; reader->at++) {
    const char *escape;
    long        code;

    if (*reader->at != '\\') {
      *to++ = *reader->at;
      continue;
    }
    reader->at++;
    escape = *reader->at ? strchr(from, *reader->at) : NULL;
    if (escape) *to++ = into[escape - from];
    else if (*reader->at != 'u') return NULL;
    if (escape) continue;
    code = Code(reader->at + 1);
    if (code < 0) return NULL;
    reader->at += 4;
    if (code >= 0xd800 && code < 0xdc00 && reader->at[1] == '\\' && reader->at[2] == 'u' && Code(reader->at + 3) > 0) {
      code = 0x10000 + ((code - 0xd800) << 10) + (Code(reader->at + 3) - 0xdc00);
      reader->at += 6;
    }
    to = Put(to, code);
  }
  if (*reader->at != '"') return NULL;
  reader->at++;
  *to = '\0';
  return text;
}

/* Members of a list or an object, up to its end. */
static PetscInt ReadMembers(Reader *reader, PetscBool object)
{
  const char     end  = object ? '}' : ']';
  const PetscInt node = Add(reader->json, object ? MPM_JSON_OBJECT : MPM_JSON_LIST);
  PetscInt       last = -1;

  Skip(reader);
  if (node >= 0 && *reader->at == end) {
    reader->at++;
    return node;
  }
  while (node >= 0) {
    const char *key = NULL;
    PetscInt    child;

    Skip(reader);
    if (object) {
      if (*reader->at++ != '"' || !(key = ReadText(reader))) return -1;
      Skip(reader);
      if (*reader->at++ != ':') return -1;
    }
    child = ReadValue(reader);
    if (child < 0) return -1;
    reader->json->node[child].key = key;
    if (last < 0) reader->json->node[node].child = child;
    else reader->json->node[last].next = child;
    last = child;
    Skip(reader);
    if (*reader->at == end) {
      reader->at++;
      return node;
    }
    if (*reader->at++ != ',') return -1;
  }
  return -1;
}

/* A number or a word; ends are marked once all has been read, for what follows is needed. */
static PetscInt ReadPlain(Reader *reader)
{
  static const char *const words[] = {"true", "false", "null"};
  char                    *end;
  PetscReal                number = strtod(reader->at, &end);
  PetscInt                 node;

  for (int k = 0; k < 3; k++) {
    if (strncmp(reader->at, words[k], strlen(words[k]))) continue;
    node = Add(reader->json, MPM_JSON_WORD);
    if (node >= 0) reader->json->node[node].text = words[k];
    reader->at += strlen(words[k]);
    return node;
  }
  if (end == reader->at || !strchr("-0123456789", *reader->at)) return -1;
  node = Add(reader->json, MPM_JSON_NUMBER);
  if (node >= 0) reader->json->node[node].number = number;
  reader->at = end;
  return node;
}

static PetscInt ReadValue(Reader *reader)
{
  PetscInt node;

  Skip(reader);
  if (++reader->depth > DEEPEST) return -1;
  if (*reader->at == '{' || *reader->at == '[') {
    reader->at++;
    node = ReadMembers(reader, (PetscBool)(reader->at[-1] == '{'));
  } else if (*reader->at == '"') {
    reader->at++;
    node = Add(reader->json, MPM_JSON_TEXT);
    if (node >= 0 && !(reader->json->node[node].text = ReadText(reader))) node = -1;
  } else {
    node = ReadPlain(reader);
  }
  reader->depth--;
  return node;
}

PetscInt MpmJsonParse(char *text, MpmJson *json)
{
  Reader reader = {.json = json, .at = text};

  json->text = text;
  if (!strncmp(text, "\xef\xbb\xbf", 3)) reader.at += 3;
  if (ReadValue(&reader) < 0) return (PetscInt)(reader.at - text);
  Skip(&reader);
  return *reader.at ? (PetscInt)(reader.at - text) : -1;
}

void MpmJsonDestroy(MpmJson *json)
{
  (void)PetscFree(json->text);
  free(json->node);
  *json = (MpmJson){0};
}

PetscInt MpmJsonMember(const MpmJson *json, PetscInt node, const char *key)
{
  PetscInt k = node < 0 || json->node[node].type != MPM_JSON_OBJECT ? -1 : json->node[node].child;

  while (k >= 0 && strcmp(json->node[k].key, key)) k = json->node[k].next;
  return k;
}

const char *MpmJsonText(const MpmJson *json, PetscInt node)
{
  return node < 0 ? NULL : json->node[node].text;
}
