/*
  Two-scale relations of cardinal B-splines. With r cells as one, the coarse spline of degree p is

    B(x/r) = sum_k m_k b(x - k) ,    sum_k m_k z^k = r ((1 + z + ... + z^{r-1})/r)^{p+1} ,

  k counted from the middle: 1/2, 1, 1/2 for p = 1 and r = 2; 1, 4, 6, 4, 1 over 8 for p = 3; 1, 3, 6, 7, 6, 3, 1 over 9
  for p = 2 and r = 3. The middle is a node where (p + 1)(r - 1) is even.

  At an edge the node beyond has a coefficient that follows from the others (grid/shape.h), on the fine and on the
  coarse lattice. A spline with linear ends has no second derivative there; one with open ends is one polynomial on its
  first intervals. Coarse ones of either kind have that on the fine lattice, too. The unknown of an open edge's node is
  the spline's value.

  Lagrange elements have the coarse functions' values at the fine nodes.

  Sources: Lane and Riesenfeld (1980), doi:10.1109/TPAMI.1980.4766968 (subdivision of B-splines); de Boor (1978), A
  Practical Guide to Splines, IV (ends).
*/
#include "grid/grid.h"
#include "grid/shape_element.h"
#include "levels/two_scale.h"

/* Most numbers of the relation: degree 3, three cells as one. */
#define MASK_MOST 16

/* The factors m_k of a spline, and their number. */
static PetscInt MakeMask(PetscInt degree, PetscInt ratio, PetscReal mask[MASK_MOST])
{
  PetscInt count = 1;

  mask[0] = (PetscReal)ratio;
  for (PetscInt k = 0; k <= degree; k++) {
    PetscReal next[MASK_MOST] = {0.};

    for (PetscInt i = 0; i < count; i++)
      for (PetscInt j = 0; j < ratio; j++) next[i + j] += mask[i] / (PetscReal)ratio;
    count += ratio - 1;
    for (PetscInt i = 0; i < count; i++) mask[i] = next[i];
  }
  return count;
}

/* Places around the node at hand: coarse nodes from `base` on, and the share of each. */
typedef struct {
  PetscInt  base;
  PetscReal share[2 * MPM_TWO_SCALE_MOST];
} Row;

/* A coarse coefficient by unknowns of the coarse lattice, times `share`. */
static void AddCoefficient(const MpmTwoScale *relation, PetscInt node, PetscReal share, Row *row)
{
  const PetscInt    degree = relation->degree, last = relation->coarse;
  const MpmEdgeType edge = MpmEdgeOf(relation->edge, degree, last);
  const PetscBool   open = (PetscBool)(edge == MPM_EDGE_OPEN);

  if (node < 0 || (open && node == 0)) {
    for (PetscInt k = 0; k <= PetscMin(degree, last); k++)
      row->share[k - row->base] += share * MpmEdgeCoefficient(edge, degree, -node, k);
  } else if (node > last || (open && node == last)) {
    for (PetscInt k = 0; k <= PetscMin(degree, last); k++)
      row->share[last - k - row->base] += share * MpmEdgeCoefficient(edge, degree, node - last, k);
  } else row->share[node - row->base] += share;
}

PetscInt MpmTwoScaleRow(const MpmTwoScale *relation, PetscInt node, PetscInt *first, PetscReal weight[])
{
  const PetscInt  ratio = relation->ratio, last = relation->coarse, middle = node / ratio;
  const PetscInt  degree = relation->degree % 2 == 0 && ratio % 2 == 0 ? relation->degree + 1 : relation->degree;
  const PetscBool open   = (PetscBool)(MpmEdgeOf(relation->edge, relation->degree, relation->fine) == MPM_EDGE_OPEN);
  const PetscBool ends   = (PetscBool)(node == 0 || (node == relation->fine && node == ratio * last));
  PetscReal       mask[MASK_MOST];
  Row             row   = {.base = PetscMax(middle - MPM_TWO_SCALE_MOST, 0)};
  const PetscInt  half  = MakeMask(degree, ratio, mask) / 2;
  PetscInt        begin = 0, end = 2 * MPM_TWO_SCALE_MOST;

  if (open && ends) row.share[middle - row.base] = 1.;
  for (PetscInt k = PetscMax(middle - half, -1); !(open && ends) && k <= PetscMin(middle + half, last) + 1; k++) {
    const PetscInt place = node - ratio * k + half;

    if (place >= 0 && place <= 2 * half) AddCoefficient(relation, k, mask[place], &row);
  }
  while (begin < end && row.share[begin] == 0.) begin++;
  while (end > begin && row.share[end - 1] == 0.) end--;
  end    = PetscMin(end, begin + MPM_TWO_SCALE_MOST);
  *first = row.base + begin;
  for (PetscInt k = begin; k < end; k++) weight[k - begin] = row.share[k];
  return end - begin;
}

/* Values of coarse functions at nodes where they are zero are below this. */
#define NOTHING 1e-13

PetscInt MpmElementScaleRow(const MpmElementScale *relation, PetscInt node, PetscInt *first, PetscReal weight[])
{
  const PetscInt  last = (relation->cells - 1) / relation->ratio, cell = node / relation->fine;
  const PetscInt  coarse = PetscMin(cell / relation->ratio, last), order = relation->coarse;
  const PetscReal xi = (PetscReal)cell + MpmCellNodes(relation->fine)[node % relation->fine];
  const PetscReal x  = xi / (PetscReal)relation->ratio - (PetscReal)coarse; /* in the coarse cell, 0 to 1 */
  PetscReal       value[MPM_TWO_SCALE_MOST] = {1. - x, x};
  PetscInt        begin = 0, end = order + 1;

  if (order > 1) MpmElementDerivatives(order, 0, x - 0.5, value);
  while (begin < end && PetscAbsReal(value[begin]) < NOTHING) begin++;
  while (end > begin && PetscAbsReal(value[end - 1]) < NOTHING) end--;
  *first = coarse * order + begin;
  for (PetscInt k = begin; k < end; k++) weight[k - begin] = value[k];
  return end - begin;
}
