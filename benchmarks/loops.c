// The forces of linear springs and dashpots, and nothing else: what kernels are compared with.
#include <math.h>
// One spring after the other.
void one_by_one(long times, long nodes, const long *first, const int *other, const double *c,
              const double *d, const double *rest, const double *inverse, const double *x,
              const double *v, double *a) {
  for (long t = 0; t < times; t++) {
    for (long i = 0; i < 3 * nodes; i++) a[i] = 0.0;
    for (long n = 0; n < nodes; n++) {
      const double *xi = x + 3 * n, *vi = v + 3 * n;
      double f0 = 0, f1 = 0, f2 = 0;
      for (long s = first[n]; s < first[n + 1]; s++) {
        const double *xj = x + other[s], *vj = v + other[s];
        double r0 = xj[0] - xi[0], r1 = xj[1] - xi[1], r2 = xj[2] - xi[2];
        double length = sqrt(r0 * r0 + r1 * r1 + r2 * r2), over = 1.0 / (length + 1e-200);
        double w = (r0 * (vj[0] - vi[0]) + r1 * (vj[1] - vi[1]) + r2 * (vj[2] - vi[2])) * over;
        double tension = (c[s] * (length - rest[s]) + d[s] * w) * over;
        double *aj = a + other[s];
        f0 += tension * r0; f1 += tension * r1; f2 += tension * r2;
        aj[0] -= tension * r0; aj[1] -= tension * r1; aj[2] -= tension * r2;
      }
      a[3 * n] += f0; a[3 * n + 1] += f1; a[3 * n + 2] += f2;
    }
    for (long n = 0; n < nodes; n++)
      for (long k = 3 * n; k < 3 * n + 3; k++) a[k] *= inverse[n];
  }
}

// Springs in runs of nodes (i, j), (i + 1, j + 1), ..., by vector instructions. Coordinates are
// apart: rows of x and v, and of a, with room for what fills the ends of runs. Runs are so short
// that forces of one are kept in the nearest cache, because its lower and upper nodes may be the
// same. A length at rest below zero is no spring.
void in_runs(long times, long nodes, long row, long runs, const long *low, const long *high,
             const long *length, const long *at, const double *c, const double *d,
             const double *rest, const double *inverse, const double *restrict x,
             const double *restrict v, double *restrict a) {
  double p[3][256];
  for (long t = 0; t < times; t++) {
    for (long i = 0; i < 3 * row; i++) a[i] = 0.0;
    for (long run = 0; run < runs; run++) {
      long i = low[run], j = high[run], k = at[run], count = length[run];
      for (long s = 0; s < count; s++) {
        double r0 = x[j + s] - x[i + s], r1 = x[j + s + row] - x[i + s + row];
        double r2 = x[j + s + 2 * row] - x[i + s + 2 * row];
        double u0 = v[j + s] - v[i + s], u1 = v[j + s + row] - v[i + s + row];
        double u2 = v[j + s + 2 * row] - v[i + s + 2 * row];
        double len = sqrt(r0 * r0 + r1 * r1 + r2 * r2), over = 1.0 / (len + 1e-200);
        double w = (r0 * u0 + r1 * u1 + r2 * u2) * over;
        double tension = (c[k + s] * (len - rest[k + s]) + d[k + s] * w) * over;
        tension = rest[k + s] >= 0.0 ? tension : 0.0;
        p[0][s] = tension * r0, p[1][s] = tension * r1, p[2][s] = tension * r2;
      }
      for (long axis = 0; axis < 3; axis++) {
        double *lower = a + axis * row + i, *upper = a + axis * row + j;
        for (long s = 0; s < count; s++) lower[s] += p[axis][s];
        for (long s = 0; s < count; s++) upper[s] -= p[axis][s];
      }
    }
    for (long axis = 0; axis < 3; axis++)
      for (long n = 0; n < nodes; n++) a[axis * row + n] *= inverse[n];
  }
}
