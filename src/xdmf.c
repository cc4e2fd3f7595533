/*
  The XDMF index (XDMF 2 and 3 as ParaView and VisIt read it).
*/
#include "mpmxdmf.h"

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

static PetscErrorCode AppendDataItem(MpmTextFile *grids, const MpmXdmfState *state, PetscInt i)
{
  const MpmDataset *dataset   = &state->datasets[i];
  size_t            precision = state->integer[i] ? sizeof(PetscInt) : sizeof(PetscReal);

  PetscFunctionBeginUser;
  PetscCall(
    MpmTextFileAppend(grids, "          <DataItem Format=\"HDF\" NumberType=\"%s\" Precision=\"%zu\" Dimensions=\"%lld",
                      state->integer[i] ? "Int" : "Float", precision, (long long)state->points));
  if (dataset->components > 1) PetscCall(MpmTextFileAppend(grids, " %lld", (long long)dataset->components));
  PetscCall(MpmTextFileAppend(grids, "\">"));
  PetscCall(AppendEscaped(grids, state->file));
  PetscCall(MpmTextFileAppend(grids, ":%s/", state->group));
  PetscCall(AppendEscaped(grids, dataset->name));
  PetscCall(MpmTextFileAppend(grids, "</DataItem>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Six components are xx, yy, zz, xy, yz, xz, which is not the order that XDMF's Tensor6 implies; a reader that rotates
  or diagonalises would be wrong without a word. Matrix promises nothing. Nine row-major components are what Tensor
  means.
*/
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

static PetscErrorCode AppendAttribute(MpmTextFile *grids, const MpmXdmfState *state, PetscInt i)
{
  const MpmDataset *dataset = &state->datasets[i];

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(grids, "        <Attribute Name=\""));
  PetscCall(AppendEscaped(grids, dataset->name));
  PetscCall(MpmTextFileAppend(grids, "\" AttributeType=\"%s\" Center=\"Node\">\n", AttributeType(dataset->components)));
  PetscCall(AppendDataItem(grids, state, i));
  PetscCall(MpmTextFileAppend(grids, "        </Attribute>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmXdmfAppend(MpmTextFile *grids, const MpmXdmfState *state)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(grids,
                              "      <Grid Name=\"points\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
                              (double)state->time));
  PetscCall(MpmTextFileAppend(
    grids, "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%lld\" NodesPerElement=\"1\"/>\n",
    (long long)state->points));
  for (PetscInt i = 0; i < state->dataset_count; ++i) {
    const MpmDataset *dataset = &state->datasets[i];
    PetscBool         geometry;
    PetscCall(PetscStrcmp(dataset->name, "position", &geometry));
    if (geometry) {
      PetscCall(
        MpmTextFileAppend(grids, "        <Geometry GeometryType=\"%s\">\n", dataset->components == 2 ? "XY" : "XYZ"));
      PetscCall(AppendDataItem(grids, state, i));
      PetscCall(MpmTextFileAppend(grids, "        </Geometry>\n"));
    } else {
      PetscCall(AppendAttribute(grids, state, i));
    }
  }
  PetscCall(MpmTextFileAppend(grids, "      </Grid>\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmXdmfWrite(MPI_Comm comm, const char *path, const MpmTextFile *grids)
{
  MpmTextFile        head = MPM_TEXT_FILE_EMPTY, foot = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *texts[] = {&head, grids, &foot};
  PetscErrorCode     written;

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(&head,
                              "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
                              "    <Grid Name=\"states\" GridType=\"Collection\" CollectionType=\"Temporal\">\n"));
  PetscCall(MpmTextFileAppend(&foot, "    </Grid>\n  </Domain>\n</Xdmf>\n"));
  written = MpmTextFileWrite(comm, path, 3, texts);
  PetscCall(MpmTextFileDestroy(&head));
  PetscCall(MpmTextFileDestroy(&foot));
  PetscCall(written);
  PetscFunctionReturn(PETSC_SUCCESS);
}
