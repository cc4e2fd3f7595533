/*
  The XDMF index (XDMF 2 and 3 as ParaView and VisIt read it).
*/
#include <string.h>
#include "io/xdmf.h"

/* Text inside an attribute's quotes. */
static PetscErrorCode AppendEscaped(MpmTextFile *text, const char *value)
{
  PetscFunctionBeginUser;
  for (const char *c = value; *c; ++c) {
    if (*c == '&') PetscCall(MpmTextFileAppend(text, "&amp;"));
    else if (*c == '<') PetscCall(MpmTextFileAppend(text, "&lt;"));
    else if (*c == '>') PetscCall(MpmTextFileAppend(text, "&gt;"));
    else if (*c == '"') PetscCall(MpmTextFileAppend(text, "&quot;"));
    else PetscCall(MpmTextFileAppend(text, "%c", *c));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Components of a dataset in the index: symmetric tensors are shown in full. */
static PetscInt Components(const MpmXdmfTable *table, PetscInt i)
{
  return MpmXdmfIsTensor(table->datasets[i].components, table->integer[i]) ? 9 : table->datasets[i].components;
}

static PetscErrorCode AppendDataItem(MpmTextFile *grids, const MpmXdmfState *state, const MpmXdmfTable *table,
                                     PetscInt i)
{
  const MpmDataset *dataset    = &table->datasets[i];
  const PetscInt    components = Components(table, i);
  const size_t      precision  = table->integer[i] ? sizeof(PetscInt) : state->real_size;

  PetscFunctionBeginUser;
  PetscCall(
    MpmTextFileAppend(grids, "          <DataItem Format=\"HDF\" NumberType=\"%s\" Precision=\"%zu\" Dimensions=\"%lld",
                      table->integer[i] ? "Int" : "Float", precision, (long long)table->rows));
  if (components > 1) PetscCall(MpmTextFileAppend(grids, " %lld", (long long)components));
  PetscCall(MpmTextFileAppend(grids, "\">"));
  PetscCall(AppendEscaped(grids, state->file));
  PetscCall(MpmTextFileAppend(grids, ":%s%s/", components == dataset->components ? "" : MPM_XDMF_TENSORS,
                              table == &state->cells ? state->cell_group : state->group));
  PetscCall(AppendEscaped(grids, dataset->name));
  PetscCall(MpmTextFileAppend(grids, "</DataItem>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two components are a vector in the plane; readers add the third. Nine are row-major. */
static const char *AttributeType(PetscInt components)
{
  switch (components) {
  case 1:
    return "Scalar";
  case 2:
  case 3:
    return "Vector";
  case 9:
    return "Tensor";
  default:
    return "Matrix";
  }
}

static PetscErrorCode AppendAttribute(MpmTextFile *grids, const MpmXdmfState *state, const MpmXdmfTable *table,
                                      PetscInt i)
{
  const MpmDataset *dataset = &table->datasets[i];

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(grids, "        <Attribute Name=\""));
  PetscCall(AppendEscaped(grids, dataset->name));
  PetscCall(MpmTextFileAppend(grids, "\" AttributeType=\"%s\" Center=\"%s\">\n", AttributeType(Components(table, i)),
                              table == &state->nodes ? "Node" : "Cell"));
  PetscCall(AppendDataItem(grids, state, table, i));
  PetscCall(MpmTextFileAppend(grids, "        </Attribute>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A cell of its own for each point, whose corner is its row; or the grid's cells. */
static PetscErrorCode AppendTopology(MpmTextFile *grids, const MpmXdmfState *state)
{
  PetscFunctionBeginUser;
  if (!state->cells.dataset_count) {
    const long long rows = (long long)state->nodes.rows;

    PetscCall(MpmTextFileAppend(
      grids, "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%lld\" NodesPerElement=\"1\">\n", rows));
    PetscCall(MpmTextFileAppend(
      grids, "          <DataItem Format=\"HDF\" NumberType=\"Int\" Precision=\"%zu\" Dimensions=\"%lld 1\">",
      sizeof(PetscInt), rows));
    PetscCall(AppendEscaped(grids, state->file));
    PetscCall(MpmTextFileAppend(grids, ":%s</DataItem>\n", state->numbers));
  } else {
    for (PetscInt i = 0; i < state->cells.dataset_count; i++) {
      const MpmDataset *dataset = &state->cells.datasets[i];

      if (strcmp(dataset->name, "nodes")) continue;
      PetscCall(MpmTextFileAppend(grids, "        <Topology TopologyType=\"%s\" NumberOfElements=\"%lld\">\n",
                                  dataset->components == 4 ? "Quadrilateral" : "Hexahedron",
                                  (long long)state->cells.rows));
      PetscCall(AppendDataItem(grids, state, &state->cells, i));
    }
  }
  PetscCall(MpmTextFileAppend(grids, "        </Topology>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The grid of a state. Positions are a field, too: some readers know one geometry for all states. */
static PetscErrorCode AppendGrid(MpmTextFile *grids, const MpmXdmfState *state, PetscBool timed)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(grids, "      <Grid Name=\"%s\" GridType=\"Uniform\">\n",
                              state->cells.dataset_count ? "grid" : "points"));
  if (timed) PetscCall(MpmTextFileAppend(grids, "        <Time Value=\"%.17g\"/>\n", (double)state->time));
  PetscCall(AppendTopology(grids, state));
  for (PetscInt i = 0; i < state->nodes.dataset_count; ++i) {
    const MpmDataset *dataset = &state->nodes.datasets[i];

    PetscCall(AppendAttribute(grids, state, &state->nodes, i));
    if (strcmp(dataset->name, "position")) continue;
    PetscCall(
      MpmTextFileAppend(grids, "        <Geometry GeometryType=\"%s\">\n", dataset->components == 2 ? "XY" : "XYZ"));
    PetscCall(AppendDataItem(grids, state, &state->nodes, i));
    PetscCall(MpmTextFileAppend(grids, "        </Geometry>\n"));
  }
  for (PetscInt i = 0; i < state->cells.dataset_count; ++i) {
    if (strcmp(state->cells.datasets[i].name, "nodes")) PetscCall(AppendAttribute(grids, state, &state->cells, i));
  }
  PetscCall(MpmTextFileAppend(grids, "      </Grid>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmXdmfAppend(MpmTextFile *grids, const MpmXdmfState *state)
{
  PetscFunctionBeginUser;
  if (state->nodes.rows) PetscCall(AppendGrid(grids, state, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define HEAD "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
#define TAIL "  </Domain>\n</Xdmf>\n"

PetscErrorCode MpmXdmfWriteAlone(MPI_Comm comm, const char *path, const MpmXdmfState *state)
{
  MpmTextFile        text  = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *whole = &text;
  PetscErrorCode     written;

  PetscFunctionBeginUser;
  if (!state->nodes.rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextFileAppend(&text, HEAD));
  PetscCall(AppendGrid(&text, state, PETSC_FALSE));
  PetscCall(MpmTextFileAppend(&text, TAIL));
  written = MpmTextFileWrite(comm, path, 1, &whole);
  PetscCall(MpmTextFileDestroy(&text));
  PetscCall(written);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmXdmfWrite(MPI_Comm comm, const char *path, PetscInt count, const char *const names[],
                            const MpmTextFile *const grids[])
{
  MpmTextFile        text  = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *whole = &text;
  PetscErrorCode     written;

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(&text, HEAD));
  for (PetscInt i = 0; i < count; i++) {
    if (!grids[i]->length) continue;
    PetscCall(MpmTextFileAppend(
      &text, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n%s    </Grid>\n", names[i],
      grids[i]->data));
  }
  PetscCall(MpmTextFileAppend(&text, TAIL));
  written = MpmTextFileWrite(comm, path, 1, &whole);
  PetscCall(MpmTextFileDestroy(&text));
  PetscCall(written);
  PetscFunctionReturn(PETSC_SUCCESS);
}
