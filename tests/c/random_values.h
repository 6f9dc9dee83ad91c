/* Random arguments for the misuse tests: mostly sensible, now and then everything that an importer should not give. */

#ifndef RANDOM_VALUES_H
#define RANDOM_VALUES_H

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST = 12, SLOTS = 4 };

static uint64_t seed = 1;

static unsigned below(unsigned n) /* xorshift, Marsaglia (2003) */
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (unsigned)(seed >> 33) % n;
}

static int rarely(void) { return below(20) == 0; }

static double number(void)
{
    static const double odd[] = {0, -1, NAN, INFINITY, -INFINITY, 1e308, -1e308, 1e-308, 1e12};
    if (below(4) == 0) return odd[below(sizeof odd / sizeof odd[0])];
    return (below(2000) - 1000.0) / (1 + below(1000));
}

static double step_size(void)
{
    static const double odd[] = {0, -0.01, NAN, INFINITY, 1e-300, -INFINITY, 0.3};
    return below(8) == 0 ? odd[below(sizeof odd / sizeof odd[0])] : 0.001 * (1 + below(10));
}

static unsigned reference(unsigned n) { return rarely() ? below(4000000000u) : below(n + 2); }

static void fill(unsigned *references, double *values, int *orders, unsigned n)
{
    for (unsigned i = 0; i < MOST; i++) {
        references[i] = reference(n);
        values[i] = number();
        orders[i] = (int)below(6) - 1;
    }
}

#endif
