/* Event map of two blocks with law (9), one motion at a time: what the package is timed against.
 *
 * The equations of docs/theory/flow.md in plain C: relative velocities w, needed forces e, Taylor
 * series of both, and for each signal a first contact that bounds on the coefficients prove.
 * Motions that do not return within the limits below give NaN.
 */
#include <math.h>

enum { ORDER = 18, TERMS = ORDER + 1, MAX_STEPS = 20000, MAX_EVENTS = 400 };
static const double TRUNCATION = 1e-15, LONGEST_STEP = 1.0, ROUNDING = 2.220446049250313e-16;

typedef struct {
    double k[2][2], limit[2], V, gamma, delta, eta; /* forces are over the masses */
} System;

typedef struct {
    int mode[2]; /* -1 backward, 0 riding, 1 forward */
    double w[2][TERMS], e[2][TERMS];
} Motion;

static double value(const double *c, double t)
{
    double sum = 0.0;
    for (int k = ORDER; k >= 0; k--)
        sum = sum * t + c[k];
    return sum;
}

/* Series of the state from its first coefficients. */
static void expand(const System *system, Motion *m)
{
    double u[2][TERMS]; /* 1 / (1 + gamma |w|) */
    for (int k = 0; k < ORDER; k++) {
        const double share = 1.0 / (k + 1);
        for (int i = 0; i < 2; i++) {
            if (m->mode[i] == 0) {
                m->w[i][k + 1] = 0.0;
                continue;
            }
            const double *w = m->w[i];
            const double slope = system->gamma * m->mode[i];
            double sum = 0.0, square = 0.0;
            for (int j = 1; j <= k; j++)
                sum += w[j] * u[i][k - j];
            if (k == 0)
                u[i][0] = 1.0 / (1.0 + slope * w[0]);
            else
                u[i][k] = -slope * sum * u[i][0];
            if (system->eta != 0.0)
                for (int j = 0; j <= k; j++)
                    square += w[j] * w[k - j];
            double force = (1.0 - system->delta) * u[i][k] + system->eta * square;
            if (k == 0)
                force += system->delta;
            double rate = -m->mode[i] * system->limit[i] * force - m->e[i][k];
            if (k == 0 && w[0] == 0.0 && fabs(rate) < 4.0 * ROUNDING * system->limit[i])
                rate = 0.0; /* F(0) = 1: a slip starts with zero acceleration */
            m->w[i][k + 1] = rate * share;
        }
        for (int i = 0; i < 2; i++)
            m->e[i][k + 1] = share * (system->k[i][i] * m->w[i][k]
                + system->k[i][1 - i] * m->w[1 - i][k]
                + (k == 0 ? system->V * (system->k[i][0] + system->k[i][1]) : 0.0));
    }
}

/* Step at which the last two terms of the slipping blocks are below the truncation. */
static double step_length(const Motion *m)
{
    double h = LONGEST_STEP;
    for (int i = 0; i < 2; i++) {
        if (m->mode[i] == 0)
            continue;
        for (int k = ORDER - 1; k <= ORDER; k++) {
            const double size = fmax(fabs(m->w[i][k]), fabs(m->e[i][k]));
            if (size * pow(h, k) > TRUNCATION)
                h = pow(TRUNCATION / size, 1.0 / k);
        }
    }
    return h;
}

/* First t in (0, h] where a signal that was positive is zero, or -1. On a rest of length r the
   signal lies above g + g' t - m t^2 / 2, m the smaller of two bounds of -g''. */
static double first_contact(const double *c, double h)
{
    double tail = 0.0, bound_2 = 0.0, bound_3 = 0.0;
    for (int k = ORDER; k >= 3; k--)
        tail = tail * h + fabs(c[k]);
    tail *= h * h * h;
    const double one = c[1] * h, two = c[2] * h * h;
    if (c[0] == 0.0) {
        if (one >= 0.0 && two >= 0.0 && one + two > tail)
            return -1.0;
    } else if (c[0] + fmin(0.0, one) + fmin(0.0, two) - tail > 8.0 * ROUNDING) {
        return -1.0;
    }
    for (int k = ORDER; k >= 3; k--) {
        bound_2 = bound_2 * h + k * (k - 1) * fabs(c[k]);
        bound_3 = bound_3 * h + k * (k - 1) * (k - 2) * fabs(c[k]);
    }
    bound_2 = bound_2 * h + 2.0 * fabs(c[2]);
    double t = 0.0;
    if (c[0] == 0.0) { /* leave the root at the start: half of where c1 + c2 t = bound_3 t^2 / 6 */
        const double b = c[2], a = bound_3 / 6.0;
        if (c[1] < 0.0 || (c[1] == 0.0 && b <= 0.0))
            return 0.0;
        const double root = sqrt(b * b + 4.0 * a * c[1]);
        t = fmin(h, 0.5 * (b > 0.0 ? (b + root) / (2.0 * a) : 2.0 * c[1] / (root - b)));
    }
    for (int n = 0; n < 10000; n++) {
        double g = 0.0, slope = 0.0, half = 0.0;
        for (int k = ORDER; k >= 0; k--) {
            half = half * t + slope;
            slope = slope * t + g;
            g = g * t + c[k];
        }
        if (g <= 8.0 * ROUNDING && slope <= 0.0)
            return t;
        if (t >= h)
            return -1.0;
        const double rest = h - t, positive = fmax(g, 0.0);
        const double m = fmin(bound_2, bound_3 * rest - 2.0 * half);
        double step = rest;
        if (m > 0.0) {
            const double root = sqrt(slope * slope + 2.0 * m * positive);
            step = slope > 0.0 ? (slope + root) / m : 2.0 * positive / (root - slope);
        } else if (slope < 0.0) {
            step = -positive / slope;
        }
        t = fmin(h, t + fmax(step, ROUNDING * h));
    }
    return NAN;
}

static double map(const System *system, double d)
{
    Motion m = {{0, 0}, {{0.0}}, {{0.0}}};
    double load[2], room[2]; /* how far both blocks move until the limit of either */
    for (int i = 0; i < 2; i++) {
        load[i] = system->k[i][0] + system->k[i][1];
        room[i] = (system->limit[i] - system->k[i][1] * d) / load[i];
    }
    const int first = room[0] < room[1] ? 0 : 1;
    m.mode[first] = -1;
    for (int i = 0; i < 2; i++)
        m.e[i][0] = i == first ? system->limit[i] : load[i] * room[first] + system->k[i][1] * d;
    for (int n = 0, n_events = 0; n < MAX_STEPS && n_events < MAX_EVENTS; n++) {
        expand(system, &m);
        double h = step_length(&m);
        int block = -1, limit = 0;
        for (int i = 0; i < 2; i++) {
            for (int side = m.mode[i] ? 0 : -1; side <= (m.mode[i] ? 0 : 1); side += 2) {
                double c[TERMS];
                for (int k = 0; k <= ORDER; k++)
                    c[k] = m.mode[i] ? m.mode[i] * m.w[i][k] : -side * m.e[i][k];
                if (m.mode[i] == 0)
                    c[0] += system->limit[i];
                const double t = first_contact(c, h);
                if (t != t)
                    return NAN;
                if (t >= 0.0) {
                    h = t;
                    block = i;
                    limit = side;
                }
            }
        }
        for (int i = 0; i < 2; i++) {
            m.w[i][0] = m.mode[i] ? value(m.w[i], h) : 0.0;
            m.e[i][0] = value(m.e[i], h);
        }
        if (block < 0)
            continue;
        n_events++;
        m.w[block][0] = 0.0;
        if (m.mode[block] && fabs(m.e[block][0]) < system->limit[block]) {
            m.mode[block] = 0;
            if (m.mode[1 - block] == 0)
                return (load[0] * m.e[1][0] - load[1] * m.e[0][0])
                    / (load[0] * system->k[1][1] - load[1] * system->k[0][1]);
        } else {
            const int upper = m.mode[block] ? m.e[block][0] > 0.0 : limit > 0;
            m.mode[block] = upper ? -1 : 1;
            if (limit != 0)
                m.e[block][0] = limit * system->limit[block];
        }
    }
    return NAN;
}

/* `numbers`: stiffness by rows, static limits, both over the masses; of the law, its parameters. */
void law9(long n, const double *d, double *out, const double *numbers, double V, const double *law)
{
    const System system = {{{numbers[0], numbers[1]}, {numbers[2], numbers[3]}},
                           {numbers[4], numbers[5]}, V, law[0], law[1], law[2]};
    for (long i = 0; i < n; i++)
        out[i] = map(&system, d[i]);
}
