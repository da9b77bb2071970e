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

// Hexahedra of one shape: neo-Hookean, with a bulk modulus that acts on the volume of an element
// and another one at its points. Gradients are rows of nodes and components for each point.
static double isochoric(double j, double *slope) {
  double near = j > 0.2 ? j : 0.2, root = 1.0 / cbrt(near), below = j - near;
  double first = -2.0 / 3.0 * root * root / near, bend = -5.0 / 3.0 * first / near;
  *slope = first + bend * below;
  return root * root + below * (first + 0.5 * bend * below);
}
void hexahedra(long times, long elements, long nodes, const long *corner, const double *slopes,
               const double *weight, const double *moduli, const double *x, double *f) {
  double mu = moduli[0], bulk = moduli[1], local = moduli[2];
  for (long t = 0; t < times; t++) {
    for (long i = 0; i < 3 * nodes; i++) f[i] = 0.0;
    for (long e = 0; e < elements; e++) {
      double at[24], push[24] = {0}, F[8][9], C[8][9], J[8], total = 0, volume = 0;
      for (long a = 0; a < 8; a++)
        for (long k = 0; k < 3; k++) at[3 * a + k] = x[3 * corner[8 * e + a] + k];
      for (long q = 0; q < 8; q++) {
        const double *n = slopes + 24 * q;
        double *g = F[q], *c = C[q];
        for (long k = 0; k < 9; k++) g[k] = 0.0;
        for (long a = 0; a < 8; a++)
          for (long i = 0; i < 3; i++)
            for (long k = 0; k < 3; k++) g[3 * i + k] += at[3 * a + i] * n[3 * a + k];
        c[0] = g[4] * g[8] - g[5] * g[7], c[1] = g[5] * g[6] - g[3] * g[8];
        c[2] = g[3] * g[7] - g[4] * g[6], c[3] = g[2] * g[7] - g[1] * g[8];
        c[4] = g[0] * g[8] - g[2] * g[6], c[5] = g[1] * g[6] - g[0] * g[7];
        c[6] = g[1] * g[5] - g[2] * g[4], c[7] = g[2] * g[3] - g[0] * g[5];
        c[8] = g[0] * g[4] - g[1] * g[3];
        J[q] = g[0] * c[0] + g[1] * c[1] + g[2] * c[2];
        total += weight[q] * J[q], volume += weight[q];
      }
      double swell = bulk * (total / volume - 1.0);
      for (long q = 0; q < 8; q++) {
        const double *n = slopes + 24 * q;
        double P[9], slope, i1 = 0, g = isochoric(J[q], &slope);
        for (long k = 0; k < 9; k++) i1 += F[q][k] * F[q][k];
        double s = mu * g * weight[q];
        double p = (0.5 * mu * slope * i1 + swell + local * (J[q] - 1.0)) * weight[q];
        for (long k = 0; k < 9; k++) P[k] = s * F[q][k] + p * C[q][k];
        for (long a = 0; a < 8; a++)
          for (long i = 0; i < 3; i++)
            for (long k = 0; k < 3; k++) push[3 * a + i] -= P[3 * i + k] * n[3 * a + k];
      }
      for (long a = 0; a < 8; a++)
        for (long k = 0; k < 3; k++) f[3 * corner[8 * e + a] + k] += push[3 * a + k];
    }
  }
}
