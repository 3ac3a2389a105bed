/* SPDX-License-Identifier: BSD-3-Clause */
/* The kernels have the values, sums, normalisation and slope that server/sim/schemes/README.md gives them. */
#include "sim/kernel_shape.h"
#include "tests/support/check.h"

static const double PI = 3.14159265358979323846;
static const MnsKernel ALL[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
static const double H = 0.37; /* nothing cancels at this h, in two or three dimensions */

static double W_at(const Kernel *kernel, double r)
{
    double W = -1, F = -1;
    kernel_eval(kernel, 1, &r, &W, &F);
    return W;
}

static double F_at(const Kernel *kernel, double r)
{
    double W = -1, F = -1;
    kernel_eval(kernel, 1, &r, &W, &F);
    return F;
}

/* By differences, as far as they go; all 0 from the support on, and finite where particles meet. */
static void bend_is_the_slope_of_F_over_the_distance(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int dim = 2; dim <= 3; dim++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            const KernelScale scale = kernel_scale(&kernel);
            const KernelShape shape = kernel_shape_of(ALL[k]);
            for (double q = 0.05; q < kernel.support / H - 0.01; q += 0.07) {
                const double r = q * H, step = 1e-6 * H;
                const double expected = (F_at(&kernel, r + step) - F_at(&kernel, r - step)) / (2 * step * r);
                for (int fused = 0; fused < 2; fused++)
                    assert_close(shape(&scale, r, r * r, fused).bend, expected, 2e-6 * fabs(expected) + 1e-6);
            }
            const double out = kernel.support * (1 + 1e-12);
            assert_true(shape(&scale, out, out * out, false).bend == 0);
            assert_true(isfinite(shape(&scale, 0, 0, false).bend));
        }
}

static int neighbours(const Kernel *kernel, int dim)
{
    const int reach = 9;
    int count = -1;
    for (int x = -reach; x <= reach; x++)
        for (int y = -reach; y <= reach; y++)
            for (int z = dim == 3 ? -reach : 0; z <= (dim == 3 ? reach : 0); z++)
                count += W_at(kernel, sqrt(x * x + y * y + z * z)) > 0;
    return count;
}

static void lattice_sums_and_neighbour_counts_are_those_of_the_table(void **state)
{
    (void)state;
    /* The table's sums at h = dx hold the truncated Gaussian's shell that lies exactly on its support; ours do not. */
    const double shell2 = 4 * exp(-9) / PI, shell3 = 30 * exp(-9) / pow(PI, 1.5);
    const struct {
        MnsKernel type;
        int dim;
        double smoothing, sum;
        int neighbours;
    } rows[] = {
        {MNS_WENDLAND_C2, 2, 1.0, 1.03760, 8},
        {MNS_WENDLAND_C2, 2, 1.2, 1.01795, 20},
        {MNS_WENDLAND_C2, 2, 1.3, 1.01047, 20},
        {MNS_WENDLAND_C2, 2, 1.5, 1.00514, 24},
        {MNS_WENDLAND_C2, 2, 1.6, 1.00416, 36},
        {MNS_WENDLAND_C2, 2, 1.8, 1.00212, 36},
        {MNS_WENDLAND_C2, 2, 2.0, 1.00121, 44},
        {MNS_WENDLAND_C2, 3, 1.0, 1.03384, 26},
        {MNS_WENDLAND_C2, 3, 1.2, 1.01746, 56},
        {MNS_WENDLAND_C2, 3, 1.3, 1.00950, 80},
        {MNS_WENDLAND_C2, 3, 1.5, 1.00314, 92},
        {MNS_WENDLAND_C2, 3, 1.6, 1.00271, 146},
        {MNS_WENDLAND_C2, 3, 1.8, 1.00133, 178},
        {MNS_WENDLAND_C2, 3, 2.0, 1.00055, 250},
        {MNS_TRUNCATED_GAUSSIAN, 2, 1.0, 1.00009 - shell2, 24},
        {MNS_TRUNCATED_GAUSSIAN, 2, 1.1, 0.99998, 36},
        {MNS_TRUNCATED_GAUSSIAN, 2, 1.2, 0.99976, 36},
        {MNS_TRUNCATED_GAUSSIAN, 2, 1.3, 0.99985, 44},
        {MNS_TRUNCATED_GAUSSIAN, 2, 1.5, 0.99996, 68},
        {MNS_TRUNCATED_GAUSSIAN, 3, 1.0, 1.00002 - shell3, 92},
        {MNS_TRUNCATED_GAUSSIAN, 3, 1.1, 0.99948, 146},
        {MNS_TRUNCATED_GAUSSIAN, 3, 1.2, 0.99933, 178},
        {MNS_TRUNCATED_GAUSSIAN, 3, 1.3, 0.99966, 250},
        {MNS_TRUNCATED_GAUSSIAN, 3, 1.5, 0.99958, 388},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const Kernel kernel = kernel_make(rows[k].type, rows[k].dim, rows[k].smoothing);
        const double sum = kernel_lattice_sum(&kernel, rows[k].dim, (const double[]){1, 1, 1}, kernel_quantity_number);
        assert_close(sum, rows[k].sum, 0.51e-5); /* the table has five decimals */
        assert_int_equal(neighbours(&kernel, rows[k].dim), rows[k].neighbours);
    }
}

/* Six decimals, for the two that schemes start from. */
static void standard_lattices_have_their_sums_to_six_decimals(void **state)
{
    (void)state;
    const Kernel wendland = kernel_make(MNS_WENDLAND_C2, 2, 1.3), gauss = kernel_make(MNS_TRUNCATED_GAUSSIAN, 2, 1.1);
    assert_close(kernel_lattice_sum(&wendland, 2, (const double[]){1, 1, 1}, kernel_quantity_number), 1.010473,
                 0.51e-6);
    assert_close(kernel_lattice_sum(&gauss, 2, (const double[]){1, 1, 1}, kernel_quantity_number), 0.999977, 0.51e-6);
}

static void lattice_sum_follows_a_stretched_lattice(void **state)
{
    (void)state;
    const double spacing[3] = {0.1, 0.098, 0.1015};
    for (size_t k = 0; k < 3; k++)
        for (int dim = 2; dim <= 3; dim++) {
            const Kernel kernel = kernel_make(ALL[k], dim, 0.13);
            const int reach = 6;
            double sum = 0;
            for (int x = -reach; x <= reach; x++)
                for (int y = -reach; y <= reach; y++)
                    for (int z = dim == 3 ? -reach : 0; z <= (dim == 3 ? reach : 0); z++) {
                        const double a = x * spacing[0], b = y * spacing[1], c = z * spacing[2];
                        sum += W_at(&kernel, sqrt(a * a + b * b + c * c));
                    }
            /* The same terms in another order. */
            assert_close(kernel_lattice_sum(&kernel, dim, spacing, kernel_quantity_number), sum, 1e-13 * sum);
        }
}

/* Sums of a calibrated kernel over a lattice, term by term: the number in a cell, and the mean slope along the directions. */
static void a_calibrated_kernel_is_exact_on_its_lattice(void **state)
{
    (void)state;
    const double spacing[3] = {0.1, 0.098, 0.1015};
    for (size_t k = 0; k < 3; k++)
        for (int dim = 2; dim <= 3; dim++) {
            const Kernel plain = kernel_make(ALL[k], dim, 0.13);
            Kernel kernel = plain;
            kernel_calibrate(&kernel, dim, spacing);
            const double volume = spacing[0] * spacing[1] * (dim == 3 ? spacing[2] : 1);
            double number = 0, slope = 0;
            for (int x = -6; x <= 6; x++)
                for (int y = -6; y <= 6; y++)
                    for (int z = dim == 3 ? -6 : 0; z <= (dim == 3 ? 6 : 0); z++) {
                        const double a = x * spacing[0], b = y * spacing[1], c = z * spacing[2];
                        const double r = sqrt(a * a + b * b + c * c);
                        number += volume * W_at(&kernel, r);
                        slope -= volume * F_at(&kernel, r) * (a * a + b * b + c * c) / dim;
                    }
            assert_close(number, 1, 1e-13); /* rounding */
            assert_close(slope, 1, 1e-13);
            assert_true(kernel.h == plain.h && kernel.support == plain.support);
        }
}

/* What there is to calibrate, for the kernel that P3 uses: no refinement changes these. */
static void sums_over_lattices_are_not_the_integrals(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        const double dx = k ? 0.001 : 1;
        Kernel kernel = kernel_make(MNS_WENDLAND_C2, 2, 1.3 * dx);
        const double plain = F_at(&kernel, dx) / W_at(&kernel, dx);
        kernel_calibrate(&kernel, 2, (const double[]){dx, dx, dx});
        const double calibrated = F_at(&kernel, dx) / W_at(&kernel, dx);
        assert_close(calibrated / plain, 1.010473 / 0.974, 1e-3);
    }
}

/* Simpson's rule over shells. */
static double volume_integral(const Kernel *kernel, int dim)
{
    const int n = 20000;
    const double step = kernel->support / n;
    double sum = 0;
    for (int k = 0; k <= n; k++) {
        /* From inside: the truncated Gaussian jumps at its support. */
        const double r = k == n ? kernel->support * (1 - 1e-15) : k * step;
        const double shell = dim == 2 ? 2 * PI * r : 4 * PI * r * r;
        sum += (k == 0 || k == n ? 1 : k % 2 ? 4 : 2) * shell * W_at(kernel, r);
    }
    return sum * step / 3;
}

static void kernels_hold_unit_mass_and_the_truncated_one_what_is_known(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double gauss = dim == 2 ? 1 - exp(-9) : erf(3) - 6 / sqrt(PI) * exp(-9);
        const double masses[] = {1, gauss, 1};
        for (size_t k = 0; k < 3; k++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            /* Error of Simpson's rule at 10^4 intervals of functions with bounded fourth derivative. */
            assert_close(volume_integral(&kernel, dim), masses[k], 1e-11);
        }
    }
}

static void F_is_the_slope_over_the_distance(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < 3; k++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            const double e = 1e-4 * H;
            for (double r = 0.043 * H; r < kernel.support - e; r += 0.0917 * H) {
                const double slope = (W_at(&kernel, r + e) - W_at(&kernel, r - e)) / (2 * e);
                /* The difference is off by e^2 / 6 of the third derivative, 15 W(0) / h^3 at most, over the smallest
                 * r. */
                assert_close(F_at(&kernel, r), slope / r, 1e-6 * kernel_at_zero(&kernel) / (H * H));
                assert_true(F_at(&kernel, r) < 0);
            }
        }
}

static void the_gaussian_is_that_of_the_c_library(void **state)
{
    (void)state;
    const Kernel kernel = kernel_make(MNS_TRUNCATED_GAUSSIAN, 2, 1);
    for (double q = 0; q < 3; q += 0.00137) {
        const double bell = exp(-q * q) / PI;
        assert_close(W_at(&kernel, q), bell, 1e-14 * bell); /* what bell() promises */
        assert_close(F_at(&kernel, q), -2 * bell, 2e-14 * bell);
    }
}

static void nothing_is_left_from_the_support_on(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < 3; k++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            assert_close(kernel.support, (ALL[k] == MNS_WENDLAND_C2 ? 2 : 3) * H, 1e-15);
            assert_true(W_at(&kernel, kernel.support * (1 - 1e-3)) > 0);
            for (double q = 1 + 1e-15; q < 8; q *= 1.37) { /* 3 h / h need not be 3 to the last bit */
                assert_true(W_at(&kernel, kernel.support * q) == 0);
                assert_true(F_at(&kernel, kernel.support * q) == 0);
            }
        }
}

static void value_at_zero_is_known(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double hd = pow(H, dim);
        const double values[] = {(dim == 2 ? 7 / (4 * PI) : 21 / (16 * PI)) / hd, 1 / (pow(PI, 0.5 * dim) * hd),
                                 66 * (dim == 2 ? 7 / (478 * PI) : 1 / (120 * PI)) / hd};
        for (size_t k = 0; k < 3; k++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            assert_close(kernel_at_zero(&kernel), values[k], 1e-14 * values[k]); /* rounding */
            assert_true(isfinite(F_at(&kernel, 0)));
        }
    }
}

static void distance_that_is_no_number_gives_no_number(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < 3; k++) {
            const Kernel kernel = kernel_make(ALL[k], dim, H);
            assert_true(isnan(W_at(&kernel, NAN)));
            assert_true(isnan(F_at(&kernel, NAN)));
        }
}

/* The vector loops treat all lanes alike, whatever the number of values. */
static void values_do_not_depend_on_their_place(void **state)
{
    (void)state;
    for (size_t k = 0; k < 3; k++) {
        const Kernel kernel = kernel_make(ALL[k], 3, H);
        double r[23], W[23], F[23];
        for (size_t n = 1; n <= 23; n++) {
            for (size_t q = 0; q < n; q++) r[q] = (double)((q * 7 + 3) % 23) / 22 * 1.1 * kernel.support;
            kernel_eval(&kernel, n, r, W, F);
            for (size_t q = 0; q < n; q++) {
                assert_true(W[q] == W_at(&kernel, r[q]));
                assert_true(F[q] == F_at(&kernel, r[q]));
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lattice_sums_and_neighbour_counts_are_those_of_the_table),
        cmocka_unit_test(standard_lattices_have_their_sums_to_six_decimals),
        cmocka_unit_test(lattice_sum_follows_a_stretched_lattice),
        cmocka_unit_test(a_calibrated_kernel_is_exact_on_its_lattice),
        cmocka_unit_test(sums_over_lattices_are_not_the_integrals),
        cmocka_unit_test(kernels_hold_unit_mass_and_the_truncated_one_what_is_known),
        cmocka_unit_test(F_is_the_slope_over_the_distance),
        cmocka_unit_test(bend_is_the_slope_of_F_over_the_distance),
        cmocka_unit_test(the_gaussian_is_that_of_the_c_library),
        cmocka_unit_test(nothing_is_left_from_the_support_on),
        cmocka_unit_test(value_at_zero_is_known),
        cmocka_unit_test(distance_that_is_no_number_gives_no_number),
        cmocka_unit_test(values_do_not_depend_on_their_place),
    };
    return cmocka_run_group_tests_name("kernel", tests, NULL, NULL);
}
