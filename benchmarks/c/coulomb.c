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
/* Two blocks; forces are over the masses. Modes: v = (1, ratio_1) q_1 + (-ratio_2, 1) q_2. */
typedef struct {
    double k[2][2], limit[2], friction[2], V;
    double load[2], determinant, square[2], frequency[2], ratio[2];
} plant;

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

/* Both blocks slip: the two modes oscillate. Returns whether one landed. */
static int both_slip(const plant *p, double *w, double *e, int *mode) {
    double r_1 = p->ratio[0], r_2 = p->ratio[1], share = 1 / (1 + r_1 * r_2);
    double part[2][2] = {{1, -r_2}, {r_1, 1}}, f[2], a[2], b[2], c[2], bound_2[2], bound_3[2], swing[2];
    for (int i = 0; i < 2; i++) f[i] = -mode[i] * p->friction[i];
    double v[2] = {w[0] + p->V, w[1] + p->V}, pull[2] = {f[0] - e[0], f[1] - e[1]};
    a[0] = share * (v[0] + r_2 * v[1]), a[1] = share * (v[1] - r_1 * v[0]);
    c[0] = share * (pull[0] + r_2 * pull[1]), c[1] = share * (pull[1] - r_1 * pull[0]);
    for (int i = 0; i < 2; i++) b[i] = c[i] / p->frequency[i], swing[i] = sqrt(a[i] * a[i] + b[i] * b[i]);
    for (int i = 0; i < 2; i++) {
        double first = fabs(part[i][0]) * swing[0] * p->square[0];
        double second = fabs(part[i][1]) * swing[1] * p->square[1];
        bound_2[i] = first + second, bound_3[i] = first * p->frequency[0] + second * p->frequency[1];
    }
    double t = 0, q[2] = {a[0], a[1]}, rate[2] = {c[0], c[1]};
    for (int step = 0; step < MAX_STEPS; step++) {
        signal g[2];
        for (int i = 0; i < 2; i++) {
            double m = mode[i];
            g[i].g = m * (part[i][0] * q[0] + part[i][1] * q[1] - p->V);
            g[i].rate = m * (part[i][0] * rate[0] + part[i][1] * rate[1]);
            g[i].bend = -m * (part[i][0] * p->square[0] * q[0] + part[i][1] * p->square[1] * q[1]);
        }
        int hit = step && reached(g[0]) ? 0 : step && reached(g[1]) ? 1 : -1;
        double h_1 = safe_step(g[0], bound_2[0], bound_3[0]), h_2 = safe_step(g[1], bound_2[1], bound_3[1]);
        double h = least(h_1, h_2);
        if (hit < 0 && h < ROUNDING * (1 + t)) hit = h_1 < h_2 ? 0 : 1;
        if (hit >= 0) {
            for (int i = 0; i < 2; i++) w[i] = mode[i] * g[i].g, e[i] = f[i] - mode[i] * g[i].rate;
            w[hit] = 0;
            mode[hit] = mode_on_belt(e[hit], p->limit[hit]);
            return 1;
        }
        t += h;
        for (int i = 0; i < 2; i++) {
            double s, k;
            sincos(p->frequency[i] * t, &s, &k);
            q[i] = a[i] * k + b[i] * s, rate[i] = p->frequency[i] * (b[i] * k - a[i] * s);
        }
    }
    return 0;
}

/* Block i slips, the other rides. Returns whether an event was found. */
static int one_slips(const plant *p, double *w, double *e, int *mode, int i) {
    int rider = 1 - i;
    double stiffness = p->k[i][i], frequency = sqrt(stiffness), period = 1 / frequency;
    double coupling = -p->k[rider][i], drift = p->V * p->load[rider];
    double f = -mode[i] * p->friction[i], steady = p->V * p->load[i] / stiffness, m = mode[i];
    double a = w[i] + steady, b = (f - e[i]) * period, swing = sqrt(a * a + b * b);
    double bound_2 = swing * stiffness, bound_3 = bound_2 * frequency;
    double ride_2 = coupling * swing * frequency, ride_3 = ride_2 * frequency;
    double t = 0, level = a, pull = b * frequency, load = e[rider];
    for (int step = 0; step < MAX_STEPS; step++) {
        double speed = level - steady, rate = drift - coupling * speed, bend = -coupling * pull;
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
        load = e[rider] + drift * t - coupling * slid;
    }
    return 0;
}

static double value(const plant *p, double d, int *events) {
    /* The block leaves first that common displacement brings to its limit first. */
    double w[2] = {0, 0}, e[2], room[2];
    for (int i = 0; i < 2; i++) room[i] = (p->limit[i] - p->k[i][1] * d) / p->load[i];
    int first = room[0] < room[1] ? 0 : 1, mode[2] = {first ? 0 : -1, first ? -1 : 0}, n = 0;
    for (int i = 0; i < 2; i++) e[i] = i == first ? p->limit[i] : p->load[i] * room[first] + p->k[i][1] * d;
    while (mode[0] || mode[1]) {
        int found = mode[0] && mode[1] ? both_slip(p, w, e, mode) : one_slips(p, w, e, mode, mode[0] ? 0 : 1);
        if (!found || ++n > MAX_EVENTS) return *events = -1, NAN;
    }
    *events = n;
    return (p->load[0] * e[1] - p->load[1] * e[0]) / p->determinant;
}

/* `numbers`: stiffness by rows, static limits, both over the masses; couplings are not positive. */
void coulomb(long n, const double *d, double *out, int *events, const double *numbers, double V,
             const double *mu) {
    plant p = {{{numbers[0], numbers[1]}, {numbers[2], numbers[3]}}, {numbers[4], numbers[5]},
               {mu[0] * numbers[4], mu[1] * numbers[5]}, V};
    double half = 0.5 * (p.k[0][0] - p.k[1][1]), mean = 0.5 * (p.k[0][0] + p.k[1][1]);
    double split = sqrt(half * half + p.k[0][1] * p.k[1][0]);
    p.determinant = p.k[0][0] * p.k[1][1] - p.k[0][1] * p.k[1][0];
    p.square[1] = mean + split, p.square[0] = p.determinant / p.square[1];
    for (int i = 0; i < 2; i++) p.load[i] = p.k[i][0] + p.k[i][1], p.frequency[i] = sqrt(p.square[i]);
    double lead = half < 0 ? p.k[0][1] * p.k[1][0] / (split - half) : half + split;
    p.ratio[0] = -lead / p.k[0][1], p.ratio[1] = -lead / p.k[1][0];
    for (long i = 0; i < n; i++) out[i] = value(&p, d[i], events + i);
}
