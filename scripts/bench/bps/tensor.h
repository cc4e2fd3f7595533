/*
  The action of a problem by tensor quadrature on cells of a box, four side by side in vector lanes. Included once for
  each number of nodes (BP_N) and quadrature points (BP_Q) an axis, which are constants here.

    values at the quadrature points by one contraction an axis, gradients by a derivative along each axis there;
    fluxes = data times values or gradients; the transposes back
*/
#define BP_JOIN3(a, b, c) a##_##b##_##c
#define BP_JOIN2(a, b, c) BP_JOIN3(a, b, c)
#define BP_OF(name)       BP_JOIN2(name, BP_N, BP_Q)

/* out = (matrix along one axis) in: `before` and `after` are the sizes of the axes that vary slower and faster. */
static inline __attribute__((always_inline)) void BP_OF(Contract)(int rows, int columns, int before, int after,
                                                                  const double *matrix, int transposed, int add,
                                                                  const Lanes *in, Lanes *out)
{
  for (int b = 0; b < before; b++) {
    for (int r = 0; r < rows; r++) {
      for (int a = 0; a < after; a++) {
        Lanes sum = add ? out[(b * rows + r) * after + a] : (Lanes){0., 0., 0., 0.};

        for (int c = 0; c < columns; c++)
          sum += (transposed ? matrix[c * rows + r] : matrix[r * columns + c]) * in[(b * columns + c) * after + a];
        out[(b * rows + r) * after + a] = sum;
      }
    }
  }
}

/* From nodes to quadrature points, or back. */
static inline __attribute__((always_inline)) void BP_OF(Interpolate)(const Tables *tables, const Lanes *in, Lanes *out)
{
  Lanes first[BP_N * BP_N * BP_Q], second[BP_N * BP_Q * BP_Q];

  BP_OF(Contract)(BP_Q, BP_N, BP_N * BP_N, 1, tables->value, 0, 0, in, first);
  BP_OF(Contract)(BP_Q, BP_N, BP_N, BP_Q, tables->value, 0, 0, first, second);
  BP_OF(Contract)(BP_Q, BP_N, 1, BP_Q * BP_Q, tables->value, 0, 0, second, out);
}
static inline __attribute__((always_inline)) void BP_OF(Integrate)(const Tables *tables, const Lanes *in, Lanes *out)
{
  Lanes first[BP_N * BP_N * BP_Q], second[BP_N * BP_Q * BP_Q];

  BP_OF(Contract)(BP_N, BP_Q, 1, BP_Q * BP_Q, tables->value, 1, 0, in, second);
  BP_OF(Contract)(BP_N, BP_Q, BP_N, BP_Q, tables->value, 1, 0, second, first);
  BP_OF(Contract)(BP_N, BP_Q, BP_N * BP_N, 1, tables->value, 1, 0, first, out);
}

/* One component of four cells: values times data, one number a point. */
static void BP_OF(Mass)(const Tables *tables, const Lanes *data, const Lanes *u, Lanes *y)
{
  Lanes at[BP_Q * BP_Q * BP_Q];

  BP_OF(Interpolate)(tables, u, at);
  for (int q = 0; q < BP_Q * BP_Q * BP_Q; q++) at[q] *= data[q];
  BP_OF(Integrate)(tables, at, y);
}

/* The gradients at the quadrature points along the axes of the cell, x fastest. */
static inline __attribute__((always_inline)) void BP_OF(Gradients)(const Tables *tables, const Lanes *u, Lanes *g)
{
  enum { ALL = BP_Q * BP_Q * BP_Q };
  Lanes at[ALL];

  BP_OF(Interpolate)(tables, u, at);
  BP_OF(Contract)(BP_Q, BP_Q, BP_Q * BP_Q, 1, tables->slope, 0, 0, at, g);
  BP_OF(Contract)(BP_Q, BP_Q, BP_Q, BP_Q, tables->slope, 0, 0, at, g + ALL);
  BP_OF(Contract)(BP_Q, BP_Q, 1, BP_Q * BP_Q, tables->slope, 0, 0, at, g + 2 * ALL);
}
static inline __attribute__((always_inline)) void BP_OF(Divergence)(const Tables *tables, const Lanes *g, Lanes *y)
{
  enum { ALL = BP_Q * BP_Q * BP_Q };
  Lanes at[ALL];

  BP_OF(Contract)(BP_Q, BP_Q, BP_Q * BP_Q, 1, tables->slope, 1, 0, g, at);
  BP_OF(Contract)(BP_Q, BP_Q, BP_Q, BP_Q, tables->slope, 1, 1, g + ALL, at);
  BP_OF(Contract)(BP_Q, BP_Q, 1, BP_Q * BP_Q, tables->slope, 1, 1, g + 2 * ALL, at);
  BP_OF(Integrate)(tables, at, y);
}

/* Gradients times the halves of symmetric 3 x 3 data. */
static void BP_OF(Diffusion)(const Tables *tables, const Lanes *data, const Lanes *u, Lanes *y)
{
  enum { ALL = BP_Q * BP_Q * BP_Q };
  Lanes g[3 * ALL];

  BP_OF(Gradients)(tables, u, g);
  for (int q = 0; q < ALL; q++) {
    const Lanes *d = &data[6 * q], x = g[q], v = g[ALL + q], z = g[2 * ALL + q];

    g[q]           = d[0] * x + d[1] * v + d[2] * z;
    g[ALL + q]     = d[1] * x + d[3] * v + d[4] * z;
    g[2 * ALL + q] = d[2] * x + d[4] * v + d[5] * z;
  }
  BP_OF(Divergence)(tables, g, y);
}

/* Three components: gradients times the halves of symmetric 9 x 9 data. */
static void BP_OF(Solid)(const Tables *tables, const Lanes *data, const Lanes *u, Lanes *y)
{
  enum { ALL = BP_Q * BP_Q * BP_Q, NODES = BP_N * BP_N * BP_N };
  Lanes g[9 * ALL];

  for (int c = 0; c < 3; c++) BP_OF(Gradients)(tables, &u[c * NODES], &g[3 * c * ALL]);
  for (int q = 0; q < ALL; q++) {
    const Lanes *d = &data[45 * q];
    Lanes        h[9], t[9];

    for (int k = 0; k < 9; k++) {
      h[k] = g[k * ALL + q];
      t[k] = (Lanes){0., 0., 0., 0.};
    }
    for (int k = 0; k < 9; k++) {
      t[k] += *d++ * h[k];
      for (int l = k + 1; l < 9; l++, d++) {
        t[k] += *d * h[l];
        t[l] += *d * h[k];
      }
    }
    for (int k = 0; k < 9; k++) g[k * ALL + q] = t[k];
  }
  for (int c = 0; c < 3; c++) BP_OF(Divergence)(tables, &g[3 * c * ALL], &y[c * NODES]);
}

#undef BP_OF
#undef BP_JOIN2
#undef BP_JOIN3
#undef BP_N
#undef BP_Q
