// The forces of linear springs and dashpots, and nothing else: what kernels are compared with.
#include <math.h>
void evaluate(long times, long nodes, const long *first, const int *other, const double *c,
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
