/*
  Outlines from GeoJSON (RFC 7946), with the `crs` of its first version, GJ 2008.
*/
#include <string.h>
#include "maps/json.h"
#include "maps/map.h"
#include "maps/outline_build.h"

/* Names of geometries; those of several parts behind those of one. */
static const char *const types[] = {"Point", "LineString", "Polygon", "MultiPoint", "MultiLineString", "MultiPolygon"};

typedef struct {
  MpmJson     json;
  MpmOutline *outline;
  char       *message;
} Source;

static void Complain(const Source *source, const char *text)
{
  (void)snprintf(source->message, MPM_MAP_MESSAGE, "is no GeoJSON: %s", text);
}

static const MpmJsonNode *Node(const Source *source, PetscInt node)
{
  return &source->json.node[node];
}

/* x and y of a list of two or three numbers. */
static PetscErrorCode ReadPosition(const Source *source, PetscInt list)
{
  PetscReal x[2] = {0., 0.};
  PetscInt  a    = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = list < 0 ? -1 : Node(source, list)->child; k >= 0 && a < 2; k = Node(source, k)->next) {
    if (Node(source, k)->type != MPM_JSON_NUMBER) break;
    x[a++] = Node(source, k)->number;
  }
  if (a < 2) Complain(source, "a position must be two numbers");
  else PetscCall(MpmOutlineAddVertex(source->outline, x[0], x[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One point, line or polygon of the last feature. */
static PetscErrorCode ReadPart(const Source *source, MpmOutlineType type, PetscInt list)
{
  PetscInt path = type == MPM_OUTLINE_POLYGON ? Node(source, list)->child : list;

  PetscFunctionBeginUser;
  for (PetscBool outer = PETSC_TRUE; path >= 0 && !source->message[0]; outer = PETSC_FALSE) {
    PetscCall(MpmOutlineAddPath(source->outline));
    if (type == MPM_OUTLINE_POINT) PetscCall(ReadPosition(source, path));
    for (PetscInt k = type == MPM_OUTLINE_POINT ? -1 : Node(source, path)->child; k >= 0 && !source->message[0];
         k          = Node(source, k)->next)
      PetscCall(ReadPosition(source, k));
    if (type != MPM_OUTLINE_POLYGON) break;
    if (!source->message[0]) PetscCall(MpmOutlineEndRing(source->outline, outer, source->message));
    path = Node(source, path)->next;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Attributes of a feature, but lists and objects. */
static PetscErrorCode ReadProperties(const Source *source, PetscInt properties)
{
  PetscFunctionBeginUser;
  for (PetscInt k = properties < 0 ? -1 : Node(source, properties)->child; k >= 0; k = Node(source, k)->next) {
    const MpmJsonNode *node = Node(source, k);
    char               number[40];

    (void)snprintf(number, sizeof(number), "%.17g", (double)node->number);
    if (node->type == MPM_JSON_LIST || node->type == MPM_JSON_OBJECT || !node->key) continue;
    if (node->type == MPM_JSON_WORD && !strcmp(node->text, "null")) continue;
    PetscCall(MpmOutlineAddAttribute(source->outline, node->key, node->type == MPM_JSON_NUMBER ? number : node->text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A feature of one geometry; collections of geometries are refused. */
static PetscErrorCode ReadGeometry(const Source *source, PetscInt geometry, PetscInt properties)
{
  const char    *name  = MpmJsonText(&source->json, MpmJsonMember(&source->json, geometry, "type"));
  const PetscInt lists = MpmJsonMember(&source->json, geometry, "coordinates");
  int            type  = 0;

  PetscFunctionBeginUser;
  while (type < 6 && (!name || strcmp(types[type], name))) type++;
  if (type == 6 || lists < 0 || Node(source, lists)->type != MPM_JSON_LIST) {
    Complain(source, "a geometry must be a Point, LineString or Polygon, or several of one kind");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmOutlineAddFeature(source->outline, (MpmOutlineType)(type % 3)));
  PetscCall(ReadProperties(source, properties));
  if (type < 3) PetscCall(ReadPart(source, (MpmOutlineType)type, lists));
  for (PetscInt k = type < 3 ? -1 : Node(source, lists)->child; k >= 0 && !source->message[0];
       k          = Node(source, k)->next)
    PetscCall(ReadPart(source, (MpmOutlineType)(type - 3), k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A feature; one without a geometry is passed over. */
static PetscErrorCode ReadFeature(const Source *source, PetscInt feature)
{
  const PetscInt geometry = MpmJsonMember(&source->json, feature, "geometry");

  PetscFunctionBeginUser;
  if (geometry < 0) Complain(source, "a feature has no geometry");
  else if (Node(source, geometry)->type == MPM_JSON_OBJECT)
    PetscCall(ReadGeometry(source, geometry, MpmJsonMember(&source->json, feature, "properties")));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadAll(const Source *source)
{
  const MpmJson *json = &source->json;
  const char    *type = MpmJsonText(json, MpmJsonMember(json, 0, "type"));
  const PetscInt crs  = MpmJsonMember(json, MpmJsonMember(json, MpmJsonMember(json, 0, "crs"), "properties"), "name");
  const PetscInt list = MpmJsonMember(json, 0, "features");

  PetscFunctionBeginUser;
  if (MpmJsonText(json, crs)) PetscCall(PetscStrallocpy(MpmJsonText(json, crs), &source->outline->system));
  if (type && !strcmp(type, "FeatureCollection") && list >= 0) {
    for (PetscInt k = Node(source, list)->child; k >= 0 && !source->message[0]; k = Node(source, k)->next)
      PetscCall(ReadFeature(source, k));
  } else if (type && !strcmp(type, "Feature")) {
    PetscCall(ReadFeature(source, 0));
  } else {
    PetscCall(ReadGeometry(source, 0, -1));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGeoJsonRead(char *text, MpmOutline *outline, char message[])
{
  Source   source = {.outline = outline, .message = message};
  PetscInt fault;

  PetscFunctionBeginUser;
  fault = MpmJsonParse(text, &source.json);
  if (fault >= 0) (void)snprintf(message, MPM_MAP_MESSAGE, "is no JSON from byte %" PetscInt_FMT " on", fault);
  else PetscCall(ReadAll(&source));
  MpmJsonDestroy(&source.json);
  PetscFunctionReturn(PETSC_SUCCESS);
}
