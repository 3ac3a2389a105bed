/* SPDX-License-Identifier: BSD-3-Clause */
/* The steady flow of two layers that P5's operators of diffusion make in a square of 20 x 40 particles whose sides hold the exact velocity:
 * the equation div tau = -1 is solved by elimination. Against P5/poiseuille_steady_flow_error.csv, by another program. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

enum { ACROSS = 20, UP = 40, SIDE = 4, INNER = ACROSS * UP };
static const double DX = 1.0 / ACROSS, DENSITY = 1000;

static double height(const double x[3])
{
    return x[1] - (UP / 2 + SIDE) * DX;
}

static int lower(const double x[3])
{
    return height(x) < 0 ? CLOUD_WATER : CLOUD_AIR;
}

/* Each layer's own parabola, beyond the plates at -1 and 1 too; the lower one has a viscosity of ratio, the upper one of 1. */
static double exact(double ratio, double y)
{
    const double slope = (ratio - 1) / (2 * (ratio + 1));
    return (slope * y - y * y / 2) / (y < 0 ? ratio : 1) + 1 / (1 + ratio);
}

typedef struct Square {
    Cloud *cloud;
    size_t inner[INNER];             /* particles whose velocity is unknown */
    double matrix[INNER][INNER + 1]; /* div tau of each for a velocity of 1 of each, and what it is to be */
} Square;

static void find_inner(Square *square)
{
    const Particles *s = &square->cloud->s;
    size_t n = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double x = s->x[0][i] / DX - SIDE, y = s->x[1][i] / DX - SIDE;
        if (x < 0 || x > ACROSS || y < 0 || y > UP) continue;
        assert_true(n < INNER);
        square->inner[n++] = i;
    }
    assert_int_equal(n, INNER);
}

static void apply(Square *square, const Term *term, size_t column, double sign)
{
    const Particles *s = &square->cloud->s;
    cloud_term(square->cloud, term);
    for (size_t k = 0; k < INNER; k++) square->matrix[k][column] += sign * DENSITY * s->a[0][square->inner[k]];
}

static void fill(Square *square, const Term *term, double ratio)
{
    Particles *s = &square->cloud->s;
    for (size_t i = 0; i < s->n; i++) {
        const double x[3] = {s->x[0][i], s->x[1][i], 0};
        s->v[0][i] = exact(ratio, height(x));
    }
    for (size_t k = 0; k < INNER; k++) s->v[0][square->inner[k]] = 0;
    apply(square, term, INNER, -1);
    for (size_t k = 0; k < INNER; k++) square->matrix[k][INNER] -= 1;
    for (size_t i = 0; i < s->n; i++) s->v[0][i] = 0;
    for (size_t k = 0; k < INNER; k++) {
        s->v[0][square->inner[k]] = 1;
        apply(square, term, k, 1);
        s->v[0][square->inner[k]] = 0;
    }
}

/* By Gauss; each row is heaviest on its diagonal, so that no pivot is sought. The solution comes to the last column. */
static void eliminate(double (*m)[INNER + 1])
{
    for (size_t k = 0; k < INNER; k++)
        for (size_t row = k + 1; row < INNER; row++) {
            const double factor = m[row][k] / m[k][k];
            for (size_t c = k; factor != 0 && c <= INNER; c++) m[row][c] -= factor * m[k][c];
        }
    for (size_t k = INNER; k-- > 0;) {
        for (size_t c = k + 1; c < INNER; c++) m[k][INNER] -= m[k][c] * m[c][INNER];
        m[k][INNER] /= m[k][k];
    }
}

/* Of the profile, root mean square over that of the exact one. */
static double error_of(const Term *term, MnsDiffusion diffusion, double ratio)
{
    Square *square = calloc(1, sizeof *square);
    assert_non_null(square);
    Cloud *cloud = square->cloud = cloud_new(&(CloudSetup){.dim = 2,
                                                           .dx = DX,
                                                           .n = {ACROSS + 2 * SIDE, UP + 2 * SIDE},
                                                           .smoothing = 2.5 / 3,
                                                           .kernel = MNS_QUINTIC_SPLINE,
                                                           .viscous = true,
                                                           .owner = lower});
    cloud_weigh(cloud, 1, DENSITY);
    cloud->model.differences.diffusion = diffusion;
    cloud->model.phase[0].mu = ratio;
    cloud->model.phase[1].mu = 1;
    cloud_term(cloud, &truncation);
    cloud_term(cloud, &mixture);
    cloud_term(cloud, &colour_gradient);
    find_inner(square);
    fill(square, term, ratio);
    eliminate(square->matrix);
    double error = 0, size = 0;
    for (size_t k = 0; k < INNER; k++) {
        const double x[3] = {0, cloud->s.x[1][square->inner[k]], 0}, u = exact(ratio, height(x));
        error += pow(square->matrix[k][INNER] - u, 2);
        size += u * u;
    }
    cloud_free(cloud);
    free(square);
    return sqrt(error / size);
}

static void errors_are_those_of_another_program(void **state)
{
    (void)state;
    static const struct {
        double ratio, harmonic, divtau;
    } known[] = {{1, 0, 0}, {2, 0.00037604, 0.00050142}, {5, 0.0076416, 0.018898}, {100, 0.088919, 0.19677}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        const double harmonic = error_of(&harmonic_diffusion, MNS_DIFFUSION_HARMONIC, known[k].ratio),
                     divtau = error_of(&divtau_diffusion, MNS_DIFFUSION_DIVTAU, known[k].ratio);
        assert_close(harmonic, known[k].harmonic, 1e-4 * known[k].harmonic + 1e-10);
        assert_close(divtau, known[k].divtau, 1e-4 * known[k].divtau + 1e-10);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(errors_are_those_of_another_program)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
