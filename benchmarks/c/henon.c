/* Basins of the Henon map, written for it: marked cells of a dense grid about the attractor, orbits
   that stay in them for some steps or leave the box. Compiled by benchmarks.c_code. */

#include <stdint.h>

void henon(long n, const double *points, double a, double b, const double *box, const double *held,
           const double *per_cell, long columns, const int8_t *marked, long hits, long max_steps,
           int64_t *fate)
{
    for (long i = 0; i < n; i++) {
        double x = points[2 * i], y = points[2 * i + 1];
        long run = 0, found = -1;
        for (long k = 0; k <= max_steps; k++) {
            if (!(x >= box[0] && x <= box[1] && y >= box[2] && y <= box[3])) {
                found = -2;
                break;
            }
            int here = 0;
            if (x >= held[0] && x <= held[1] && y >= held[2] && y <= held[3])
                here = marked[(long)((x - held[0]) * per_cell[0]) * columns
                              + (long)((y - held[2]) * per_cell[1])];
            run = here ? run + 1 : 0;
            if (run >= hits) {
                found = 0;
                break;
            }
            double next = 1.0 - a * x * x + y;
            y = b * x;
            x = next;
        }
        fate[i] = found;
    }
}
