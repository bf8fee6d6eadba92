/* The Coulomb event map in plain C, one motion after the other: what to measure against.

   State of a block: relative velocity w and the force e that it needs in order to ride. Between
   events both are closed form; the first event is found by steps over which a bound on the
   second derivative proves that no signal reaches zero (near a root that is Newton's step).
   Compile: gcc -O3 -march=native -ffast-math -fno-finite-math-only -shared -fPIC ... -lm */

#define _GNU_SOURCE
#include <math.h>

enum { MAX_EVENTS = 400, MAX_STEPS = 100000 };
static const double CAP = 0.9, ROUNDING = 1e-15;

static inline double least(double a, double b) { return a < b ? a : b; }

typedef struct { double g, rate, bend; } signal;             /* a distance and two derivatives */
typedef struct { double alpha, limit[2], friction[2], V; } plant;

/* Longest step on which a signal >= 0 stays so, given bounds on its 2nd and 3rd derivative. */
static inline double safe_step(signal f, double bound_2, double bound_3) {
    double g = f.g > 0 ? f.g : 0;
    double m = least(bound_2, bound_3 * CAP - f.bend);
    if (m <= 1e-9) return f.rate >= 0 ? CAP : least(CAP, -g / f.rate);
    double root = sqrt(f.rate * f.rate + 2 * m * g);
    return least(CAP, f.rate > 0 ? (f.rate + root) / m : 2 * g / (root - f.rate));
}

static inline int reached(signal f) { return f.g <= ROUNDING && f.rate < 0; }

/* Mode of a block on the belt: -1 backward, 0 stick, 1 forward. */
static inline int mode_on_belt(double e, double limit) { return fabs(e) < limit ? 0 : e > 0 ? -1 : 1; }

/* Both blocks slip: sum and difference of the blocks oscillate. Returns whether one landed. */
static int both_slip(const plant *p, double *w, double *e, int *mode) {
    double spread = 1 + 2 * p->alpha, beat = sqrt(spread);
    double f_1 = -mode[0] * p->friction[0], f_2 = -mode[1] * p->friction[1];
    double a = w[0] + w[1] + 2 * p->V, b = f_1 + f_2 - e[0] - e[1];
    double c = w[1] - w[0], d = (f_2 - f_1 - e[1] + e[0]) / beat;
    double swing_1 = 0.5 * sqrt(a * a + b * b), swing_2 = 0.5 * sqrt(c * c + d * d);
    double bound_2 = swing_1 + spread * swing_2, bound_3 = swing_1 + spread * beat * swing_2;
    double t = 0, sum = a, sum_rate = b, gap = c, gap_rate = beat * d;
    for (int step = 0; step < MAX_STEPS; step++) {
        signal f[2];
        for (int i = 0; i < 2; i++) {
            double side = i ? 1 : -1, m = mode[i];
            f[i].g = m * (0.5 * (sum + side * gap) - p->V);
            f[i].rate = m * 0.5 * (sum_rate + side * gap_rate);
            f[i].bend = -m * 0.5 * (sum + side * spread * gap);
        }
        int hit = step && reached(f[0]) ? 0 : step && reached(f[1]) ? 1 : -1;
        double h_1 = safe_step(f[0], bound_2, bound_3), h_2 = safe_step(f[1], bound_2, bound_3);
        double h = least(h_1, h_2);
        if (hit < 0 && h < ROUNDING * (1 + t)) hit = h_1 < h_2 ? 0 : 1;
        if (hit >= 0) {
            w[0] = 0.5 * (sum - gap) - p->V, w[1] = 0.5 * (sum + gap) - p->V;
            e[0] = f_1 - 0.5 * (sum_rate - gap_rate), e[1] = f_2 - 0.5 * (sum_rate + gap_rate);
            w[hit] = 0;
            mode[hit] = mode_on_belt(e[hit], p->limit[hit]);
            return 1;
        }
        t += h;
        double s, k, z, l;
        sincos(t, &s, &k), sincos(beat * t, &z, &l);
        sum = a * k + b * s, sum_rate = b * k - a * s;
        gap = c * l + d * z, gap_rate = beat * (d * l - c * z);
    }
    return 0;
}

/* Block i slips, the other rides. Returns whether an event was found. */
static int one_slips(const plant *p, double *w, double *e, int *mode, int i) {
    int rider = 1 - i;
    double stiffness = 1 + p->alpha, frequency = sqrt(stiffness), period = 1 / frequency;
    double f = -mode[i] * p->friction[i], steady = p->V / stiffness, m = mode[i];
    double a = w[i] + steady, b = (f - e[i]) * period, swing = sqrt(a * a + b * b);
    double bound_2 = swing * stiffness, bound_3 = bound_2 * frequency;
    double ride_2 = p->alpha * swing * frequency, ride_3 = ride_2 * frequency;
    double t = 0, level = a, pull = b * frequency, load = e[rider];
    for (int step = 0; step < MAX_STEPS; step++) {
        double speed = level - steady, rate = p->V - p->alpha * speed, bend = -p->alpha * pull;
        signal gap = {m * speed, m * pull, -m * stiffness * level};
        signal upper = {p->limit[rider] - load, -rate, -bend}, lower = {p->limit[rider] + load, rate, bend};
        double h = safe_step(gap, bound_2, bound_3), near = 0.5 * ride_2 * CAP * CAP;
        int hit = step && reached(gap) ? 1 : reached(upper) ? 2 : reached(lower) ? 3 : 0, next = 1;
        if (upper.rate < 0 || upper.g < near) {
            double reach = safe_step(upper, ride_2, ride_3);
            if (reach < h) h = reach, next = 2;
        }
        if (m > 0 && (lower.rate < 0 || lower.g < near)) {   /* backward, the load only grows */
            double reach = safe_step(lower, ride_2, ride_3);
            if (reach < h) h = reach, next = 3;
        }
        if (!hit && h < ROUNDING * (1 + t)) hit = next;
        if (hit) {
            w[i] = speed, e[i] = f - pull, e[rider] = load;
            if (hit == 1) w[i] = 0, mode[i] = mode_on_belt(e[i], p->limit[i]);
            else w[rider] = 0, mode[rider] = hit == 2 ? -1 : 1;
            return 1;
        }
        t += h;
        double s, k;
        sincos(frequency * t, &s, &k);
        level = a * k + b * s, pull = frequency * (b * k - a * s);
        double slid = period * (a * s + b * (1 - k)) - steady * t;   /* integral of w */
        load = e[rider] + p->V * t - p->alpha * slid;
    }
    return 0;
}

static double value(const plant *p, double d, int *events) {
    double spread = (1 + 2 * p->alpha) * d, w[2] = {0, 0}, e[2];
    int first = 1 + spread <= p->limit[1], mode[2] = {first ? -1 : 0, first ? 0 : -1}, n = 0;
    e[0] = first ? 1 : p->limit[1] - spread, e[1] = first ? 1 + spread : p->limit[1];
    while (mode[0] || mode[1]) {
        int found = mode[0] && mode[1] ? both_slip(p, w, e, mode) : one_slips(p, w, e, mode, mode[0] ? 0 : 1);
        if (!found || ++n > MAX_EVENTS) return *events = -1, NAN;
    }
    *events = n;
    return (e[1] - e[0]) / (1 + 2 * p->alpha);
}

void coulomb_map(long n, const double *d, double *out, int *events, double alpha, double beta, double mu, double V) {
    plant p = {alpha, {1, beta}, {mu, mu * beta}, V};
    for (long i = 0; i < n; i++) out[i] = value(&p, d[i], events + i);
}
