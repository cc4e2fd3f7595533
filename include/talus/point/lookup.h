#pragma once
/*
  Parameters of a law that are tables or data. Included by law.h.
*/

/* Rows of table `k`, the parameter's place in the law's parameter table, or numbers of its data */
MPM_FN long TableCount(const MpmLawPoint *point, int k)
{
  return point->table[k].count;
}

/* Number i of data; of a table, where x and y of row i are numbers 2 i and 2 i + 1 */
MPM_FN Real TableEntry(const MpmLawPoint *point, int k, long i)
{
#if defined(MPM_SENSITIVITY)
  const MpmLawTable *direction = point->table_direction;

  if (direction && direction[k].value)
    return RealLoad(point->table[k].value[i], RealRow(direction[k].value, i, point->columns), point->columns.count);
#endif
  return point->table[k].value[i];
}

/* y + slope (x' - x) near some x' */
typedef struct {
  Real x, y, slope;
} TableSegment;

/*
  TableSegmentAt - the segment of a table, piecewise linear, that holds x; at a row the one that begins there

  Before the first and after the last row y keeps their values, with slope 0. The table has a row at least.
*/
MPM_FN TableSegment TableSegmentAt(const MpmLawPoint *point, int k, double x)
{
  const double *value = point->table[k].value;
  const long    last  = point->table[k].count - 1;
  long          lower = 0, upper = last; /* rows around x */
  TableSegment  segment;

  if (x < value[0]) upper = 0;
  else if (x >= value[2 * last]) lower = last;
  while (upper - lower > 1) {
    const long middle = lower + (upper - lower) / 2;

    if (x < value[2 * middle]) upper = middle;
    else lower = middle;
  }
  segment.x     = TableEntry(point, k, 2 * lower);
  segment.y     = TableEntry(point, k, 2 * lower + 1);
  segment.slope = 0.;
  if (upper > lower)
    segment.slope = (TableEntry(point, k, 2 * upper + 1) - segment.y) / (TableEntry(point, k, 2 * upper) - segment.x);
  return segment;
}

/* y at x, where x follows from history and parameters alone */
MPM_FN Real TableReal(const MpmLawPoint *point, int k, Real x)
{
  const TableSegment segment = TableSegmentAt(point, k, RealValue(x));

  return segment.y + segment.slope * (x - segment.x);
}

/* y at x, where x depends on the step's increment */
MPM_FN Scalar TableScalar(const MpmLawPoint *point, int k, Scalar x)
{
  const TableSegment segment = TableSegmentAt(point, k, ScalarValue(x));

  return ScalarShift(ScalarScale(segment.slope, ScalarShift(x, -segment.x)), segment.y);
}
