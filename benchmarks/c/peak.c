/* Additions and multiplications per second that a core can do: chains of fused multiply-adds, enough
   of them side by side to hide that each waits for the one before. */

enum { CHAINS = 128 };

double peak(long rounds, double factor) {
    double x[CHAINS];
    for (int i = 0; i < CHAINS; i++) x[i] = i;
    for (long k = 0; k < rounds; k++)
        for (int i = 0; i < CHAINS; i++) x[i] = x[i] * factor + 0.5;
    double sum = 0;
    for (int i = 0; i < CHAINS; i++) sum += x[i];
    return sum;
}
