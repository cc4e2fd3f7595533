/*
  Memory of a scene, estimated before any of it is allocated: a slip in the number of cells would otherwise swap the
  machine to death.
*/
#include <unistd.h>
#include "options/options.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "model/build.h"

/* Measured with direct and multigrid solvers, from below: most scenes take more. */
#define BYTES_PER_POINT_2D 500.
#define BYTES_PER_POINT_3D 1000.
#define BYTES_PER_NODE     60. /* of the box of cells around the material, touched or not */

/* Memory of all machines that the ranks run on, in GB; infinite where the system does not report it. */
static PetscErrorCode MachineMemory(MPI_Comm comm, PetscReal *memory)
{
  MPI_Comm    node;
  PetscMPIInt rank;
  const long  pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node));
  PetscCallMPI(MPI_Comm_rank(node, &rank));
  PetscCallMPI(MPI_Comm_free(&node));
  *memory = rank ? 0. : (pages > 0 && size > 0) ? 1e-9 * (PetscReal)pages * (PetscReal)size : PETSC_INFINITY;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, memory, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMemoryCheck(const MpmOptions *options, const MpmGrid *grid, PetscInt count, const MpmBody bodies[],
                              char *const names[])
{
  const PetscReal per_point = grid->dim == 2 ? BYTES_PER_POINT_2D : BYTES_PER_POINT_3D;
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], largest = 0;
  PetscReal       limit = PETSC_INFINITY, points = 0., most = 0., nodes = 1., memory;
  PetscBool       given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(options, "memory_limit", "GB",
                           "a scene that needs more is refused at once; by default what the machines have",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &limit, &given));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (!given) PetscCall(MachineMemory(options->comm, &limit));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = grid->cells[a];
    upper[a] = 0;
  }
  for (PetscInt b = 0; b < count; b++) {
    PetscReal own;

    PetscCall(MpmBodyEstimate(bodies[b], grid, lower, upper, &own));
    points += own;
    if (own > most) largest = b;
    most = PetscMax(most, own);
  }
  for (PetscInt a = 0; a < grid->dim; a++) nodes *= PetscMax((PetscReal)(upper[a] - lower[a]), 1.);
  memory = 1e-9 * (points * per_point + nodes * PetscPowRealInt((PetscReal)grid->order, grid->dim) * BYTES_PER_NODE);
  MpmCheckInput(memory <= limit,
                "-mpm_body_%s_points_per_cell and -mpm_grid_cells: about %.2g points in a box of %.2g cells need at "
                "least %.2g GB, must stay below -mpm_memory_limit, %.3g GB",
                names[largest], (double)points, (double)nodes, (double)memory, (double)limit);
  MpmCheckInput(points < (PetscReal)PETSC_INT_MAX && nodes < (PetscReal)PETSC_INT_MAX,
                "-mpm_body_%s_points_per_cell and -mpm_grid_cells: about %.2g points in a box of %.2g cells need "
                "PETSc with 64-bit indices",
                names[largest], (double)points, (double)nodes);
  PetscFunctionReturn(PETSC_SUCCESS);
}
