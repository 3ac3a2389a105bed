/* SPDX-License-Identifier: BSD-3-Clause */
/* Density dissipation is that of P1 eq. 49 put right: nothing of a linear pressure, never a pair's volume, always towards what is
 * even, and without its gradients what a Riemann problem dissipates. The gradients are exact for linear pressures. */
#include "sim/scheme.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

static int both(const double x[3])
{
    return x[1] < 0.4 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

/* Two fluids over a floor, under a free surface that is no straight line. */
static int tank(const double x[3])
{
    if (x[1] < 0.3) return CLOUD_WALL;
    if (x[1] > 0.85 - 0.3 * (x[0] - 0.5) * (x[0] - 0.5)) return CLOUD_NOTHING;
    return x[1] < 0.5 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(int dim, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {10, 11, 8},
                                           .jitter = 0.25,
                                           .skin = 0.3,
                                           .smoothing = 1.6,
                                           .periodic = {false, false, true},
                                           .flowing = true,
                                           .owner = owner});
    Particles *s = &cloud->s;
    uint64_t seed = 31;
    cloud_stir(cloud, 6);
    for (int d = 0; d < dim; d++)
        for (size_t i = 0; i < s->n; i++) s->gradient[d][i] = 1e5 * cloud_noise(&seed);
    return cloud;
}

static const double SLOPE[3] = {4e3, -9e3, 2500}, LEVEL = 1700;

static void set_linear_pressure(Cloud *cloud)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++) {
        s->p[i] = LEVEL;
        for (int d = 0; d < s->dim; d++) s->p[i] += SLOPE[d] * s->x[d][i];
    }
}

/* Wherever the neighbours are: beside walls, at the surface, between fluids of any volume. */
static void gradients_of_linear_pressures_are_exact_everywhere(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        Particles *s = &cloud->s;
        cloud->model.periodic = false; /* a linear field is not */
        cloud->model.frequency[2] = cloud->model.period[2] = 0;
        assert_int_equal(cloud_build(cloud), MNS_OK);
        set_linear_pressure(cloud);
        cloud_term(cloud, &pressure_gradient);
        for (size_t i = 0; i < particles_fluid(s); i++)
            for (int d = 0; d < dim; d++)
                assert_close(s->gradient[d][i], SLOPE[d], 1e-10 * 1e4); /* rounding, by the condition of M */
        for (size_t i = particles_fluid(s); i < s->n; i++) assert_true(fabs(s->gradient[0][i]) != SLOPE[0]);
        cloud_free(cloud);
    }
}

/* A particle in a corner has a quarter of its neighbours, or an eighth, and these do for a gradient. */
static void gradients_are_exact_in_corners_too(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(
            &(CloudSetup){.dim = dim, .dx = 0.1, .n = {9, 8, 7}, .smoothing = 1.6, .skin = 0.3, .flowing = true});
        Particles *s = &cloud->s;
        set_linear_pressure(cloud);
        cloud_term(cloud, &pressure_gradient);
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < dim; d++) assert_close(s->gradient[d][i], SLOPE[d], 1e-11 * 1e4); /* rounding */
        cloud_free(cloud);
    }
}

static int few(const double x[3])
{
    if (x[1] > 0.1 || x[2] > 0.1) return CLOUD_NOTHING;
    return x[0] < 0.1 || (x[0] > 0.6 && x[0] < 0.9) ? CLOUD_WATER : CLOUD_NOTHING;
}

/* One alone and three in a line have no gradient that could be put right, and get none that is not finite. */
static void lonely_particles_have_no_wild_gradient(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){
            .dim = dim, .dx = 0.1, .n = {10, 3, 3}, .skin = 0.3, .smoothing = 1.6, .flowing = true, .owner = few});
        Particles *s = &cloud->s;
        assert_int_equal(s->n, 4);
        set_linear_pressure(cloud);
        cloud_term(cloud, &pressure_gradient);
        const size_t alone = cloud_index(cloud, 0), middle = cloud_index(cloud, 7), end = cloud_index(cloud, 6);
        for (int d = 0; d < dim; d++) {
            assert_true(s->gradient[d][alone] == 0);
            assert_true(d == 0 || s->gradient[d][middle] == 0);
        }
        double line = 0; /* what the sum without a correction gives */
        for (size_t j = 0; j < s->n; j++) {
            const CloudPair pair = cloud_pair(cloud, end, j);
            if (j != end) line += cloud_volume(cloud, j) * (s->p[j] - s->p[end]) * pair.F * pair.dx[0];
        }
        assert_close(s->gradient[0][end], line, 1e-9 * fabs(line));
        assert_true(line * SLOPE[0] > 0 && fabs(line) < fabs(SLOPE[0]));
        cloud_term(cloud, &density_dissipation);
        assert_true(s->rate[alone] == 0 && isfinite(s->rate[middle]));
        cloud_free(cloud);
    }
}

/* By the sum over pairs; own: without the factor that keeps a pair's volume. */
static double reference(const Cloud *cloud, size_t i, bool rest, bool keeps, double *ret_size)
{
    const Particles *s = &cloud->s;
    double sum = 0;
    *ret_size = 0;
    for (size_t j = 0; j < particles_fluid(s); j++) {
        if (j == i) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        double psi = s->p[j] - s->p[i];
        for (int d = 0; d < s->dim && rest; d++) psi += 0.5 * (s->gradient[d][i] + s->gradient[d][j]) * pair.dx[d];
        /* delta c phi psi / c^2, phi = 2 rho_i/(rho_i + rho_j), as all sound is equally fast here */
        const double phi = keeps ? 2 * s->rho[i] / (s->rho[i] + s->rho[j]) : 1;
        const double term = -cloud->model.delta / 20 * phi * psi * pair.F * pair.r * cloud_volume(cloud, j);
        sum += term;
        *ret_size = fmax(*ret_size, fabs(term));
    }
    return sum;
}

static void rates_are_those_of_the_paper_in_all_three_forms(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int form = 0; form < 3; form++) {
            Cloud *cloud = stirred(dim, tank);
            const Particles *s = &cloud->s;
            cloud->model.delta = 0.7;
            cloud->model.dissipates_rest = form != 2;
            cloud->model.keeps_pair_volume = form == 0;
            assert_true(density_dissipation.needed(&cloud->model));
            assert_true(pressure_gradient.needed(&cloud->model) == (form != 2));
            cloud_term(cloud, &density_dissipation);
            for (size_t i = 0; i < particles_fluid(s); i++) {
                double size = 0;
                const double expected = reference(cloud, i, form != 2, form == 0, &size);
                assert_close(s->rate[i], expected, 1e-12 * size); /* rounding */
            }
            cloud->model.delta = 0;
            assert_false(density_dissipation.needed(&cloud->model) || pressure_gradient.needed(&cloud->model));
            cloud_free(cloud);
        }
}

/* Also at the free surface and between fluids, where the gradients are those of the term above. */
static void a_linear_pressure_dissipates_nothing(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int form = 0; form < 2; form++) {
            Cloud *cloud = stirred(dim, tank);
            Particles *s = &cloud->s;
            cloud->model.periodic = false;
            cloud->model.frequency[2] = cloud->model.period[2] = 0;
            assert_int_equal(cloud_build(cloud), MNS_OK);
            cloud->model.keeps_pair_volume = form == 0;
            set_linear_pressure(cloud);
            cloud_term(cloud, &pressure_gradient);
            cloud_term(cloud, &density_dissipation);
            /* psi is of 1e-10 of the pressures' differences; with the plain form the largest rate is 3e4. */
            for (size_t i = 0; i < particles_fluid(s); i++) assert_close(s->rate[i], 0, 1e-6);
            cloud->model.dissipates_rest = false;
            cloud_term(cloud, &density_dissipation);
            double most = 0;
            for (size_t i = 0; i < particles_fluid(s); i++) most = fmax(most, fabs(s->rate[i]));
            assert_true(most > 10);
            cloud_free(cloud);
        }
}

/* Pairs of which one fills, by a share of what a Riemann problem dissipates; where pressures are zero that is all. */
static void closing_pairs_of_a_fluid_that_fills_resist(void **state)
{
    (void)state;
    const double share = 0.4;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, both);
        const Particles *s = &cloud->s;
        double most[2] = {0};
        cloud->model.any_fills = cloud->model.phase[CLOUD_AIR].fills = true;
        cloud->model.phase[CLOUD_AIR].resists = share;
        for (size_t i = 0; i < s->n; i++) s->p[i] = 0;
        cloud_term(cloud, &gas_dissipation);
        for (size_t i = 0; i < s->n; i++) {
            double expected[3] = {0}, size = 0;
            for (size_t j = 0; j < s->n; j++) {
                if (j == i || (s->phase[i] != CLOUD_AIR && s->phase[j] != CLOUD_AIR)) continue;
                const CloudPair pair = cloud_pair(cloud, i, j);
                const double z = cloud_impedance(cloud, i) * cloud_impedance(cloud, j) /
                                 (cloud_impedance(cloud, i) + cloud_impedance(cloud, j));
                double apart = 0;
                for (int d = 0; d < dim; d++) apart += (s->v[d][i] - s->v[d][j]) * pair.dx[d] / pair.r;
                const double force =
                    cloud_volume(cloud, i) * cloud_volume(cloud, j) * 2 * z * fmax(0, -apart) * pair.F * share;
                for (int d = 0; d < dim; d++) expected[d] -= force * pair.dx[d] / s->m[i];
                size += fabs(force * pair.r / s->m[i]);
            }
            for (int d = 0; d < dim; d++) assert_close(s->a[d][i], expected[d], 1e-11 * size); /* rounding */
            most[s->phase[i]] = fmax(most[s->phase[i]], size);
        }
        assert_true(most[CLOUD_WATER] > 0 && most[CLOUD_AIR] > 0);
        cloud_assert_no_force(cloud, 1e-12);
        cloud_free(cloud);
    }
}

/* Up to a sum of W V of 5/4 nothing is done; beyond, the share by which it grows is that of what is too much, within h/c. */
static void what_fills_takes_no_more_room_than_there_is(void **state)
{
    (void)state;
    static const double sums[] = {0.8, 1, 1.25, 1.5, 3};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, both);
        Particles *s = &cloud->s;
        const Phase *air = &cloud->model.phase[CLOUD_AIR];
        size_t grew = 0;
        cloud->model.any_fills = cloud->model.phase[CLOUD_AIR].fills = true;
        for (size_t i = 0; i < s->n; i++) s->shepard[i] = sums[i % 5];
        cloud_term(cloud, &gas_dissipation);
        for (size_t i = 0; i < s->n; i++) {
            const double over = s->phase[i] == CLOUD_AIR ? fmax(0, sums[i % 5] - 1.25) : 0;
            assert_close(s->rate[i], s->rho[i] * over * air->c / cloud->model.kernel.h, 1e-12 * s->rate[i]);
            grew += s->rate[i] > 0;
        }
        assert_true(grew > s->n / 10);
        cloud_free(cloud);
    }
}

/* The lightest of the liquids, in a domain that fluids fill and without tension; gases anywhere. */
static void the_lightest_fluid_fills_and_resists_by_how_light_it_is(void **state)
{
    (void)state;
    static const double densities[] = {1000, 900, 500, 100, 20, 1};
    static const double shares[] = {0, 1 / (81.0 * 49 * 49), 1 / (49.0 * 49), 9 * 9 / (49.0 * 49), 1, 1};
    for (int k = 0; k < 6; k++)
        for (int way = 0; way < 8; way++) {
            const bool filled = way & 1, tense = way >> 1 & 1, by_density = way >> 2 & 1, gas = k == 5,
                       fills = by_density && (gas || (k > 0 && filled && !tense));
            MnsCase c = {0};
            Model model = {.n_phases = 3, .rho_max = 1000, .rho_min = densities[k], .filled = filled, .tense = tense};
            c.scheme.dissipation.pair_average = by_density ? MNS_AVERAGE_DENSITY : MNS_AVERAGE_ARITHMETIC;
            model.phase[0].rho0 = 1000;
            model.phase[1].rho0 = k > 1 ? 950 : 1000;
            model.phase[2].rho0 = densities[k];
            scheme_dissipation.options(&model, &c);
            for (size_t of = 0; of < 3; of++) {
                assert_int_equal(model.phase[of].fills, fills && of == 2);
                assert_close(model.phase[of].resists, model.phase[of].fills ? shares[k] : 0, 1e-15);
            }
            assert_int_equal(model.any_fills, fills);
            assert_true((model.shifting > 0) == fills && model.shifts_along_interfaces == fills);
            assert_true(model.own_gradients == (fills || tense ? 1 : 0));
        }
}

/* V_i drho_i/rho_i is the volume that i gives up. */
static double lost(const Cloud *cloud, size_t i)
{
    const Particles *s = &cloud->s;
    return cloud_volume(cloud, i) * s->rate[i] / s->rho[i];
}

static int two_points(const double x[3])
{
    return x[0] < 0.1 ? CLOUD_WATER : x[0] < 0.2 ? CLOUD_AIR : CLOUD_NOTHING;
}

/* What one of a pair loses the other gains, at a ratio of densities of 1000 too; without the factor the air gains more or loses. */
static void pairs_keep_their_volume(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int keeps = 0; keeps < 2; keeps++) {
            Cloud *cloud =
                cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {3, 1, 1}, .flowing = true, .owner = two_points});
            Particles *s = &cloud->s;
            cloud_stir(cloud, 3);
            cloud->model.keeps_pair_volume = keeps;
            for (int d = 0; d < dim; d++) {
                s->gradient[d][0] = 3e4 - 7e3 * d;
                s->gradient[d][1] = -5e3 + 9e3 * d;
            }
            cloud_term(cloud, &density_dissipation);
            assert_true(s->rate[0] != 0 && s->rho[0] / s->rho[1] > 500);
            if (keeps) assert_close(lost(cloud, 0), -lost(cloud, 1), 1e-14 * fabs(lost(cloud, 0)));
            else
                assert_true(fabs(lost(cloud, 0) / lost(cloud, 1)) < 0.01 ||
                            fabs(lost(cloud, 1) / lost(cloud, 0)) < 0.01);
            cloud_free(cloud);

            cloud = stirred(dim, both);
            s = &cloud->s;
            cloud->model.keeps_pair_volume = keeps;
            cloud_term(cloud, &density_dissipation);
            double sum = 0, size = 0;
            for (size_t i = 0; i < s->n; i++) {
                sum += lost(cloud, i);
                size += fabs(lost(cloud, i));
            }
            if (keeps) assert_close(sum, 0, 1e-13 * size);
            else assert_true(fabs(sum) > 1e-3 * size);
            cloud_free(cloud);
        }
}

static int two_of_water(const double x[3])
{
    return x[0] < 0.2 ? CLOUD_WATER : CLOUD_NOTHING;
}

/* Gradients that are steeper than the difference of two pressures would make it grow: beside a gas, the pair then dissipates nothing. */
static void beside_a_gas_no_difference_grows(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int gas = 0; gas < 2; gas++)
            for (int steep = 0; steep < 2; steep++) {
                Cloud *cloud = cloud_new(
                    &(CloudSetup){.dim = dim, .dx = 0.1, .n = {3, 1, 1}, .flowing = true, .owner = two_of_water});
                Particles *s = &cloud->s;
                cloud->model.any_fills = gas;
                s->p[0] = 0;
                s->p[1] = 100;
                for (int i = 0; i < 2; i++) s->gradient[0][i] = (steep ? 2 : 0.5) * 100 / (s->x[0][1] - s->x[0][0]);
                cloud_term(cloud, &density_dissipation);
                for (int i = 0; i < 2; i++) {
                    const double towards = i == 0 ? s->rate[i] : -s->rate[i]; /* the other's pressure */
                    if (!steep) assert_true(towards > 0);
                    else if (gas) assert_true(towards == 0);
                    else assert_true(towards < 0);
                }
                cloud_free(cloud);
            }
}

/* Pressures of either sign from one particle to the next, which no gradient sees, are evened out in every form and fluid. */
static void checkerboards_are_damped(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int form = 0; form < 3; form++) {
            Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                   .dx = 0.1,
                                                   .n = {10, 8, 12},
                                                   .periodic = {true, true, true},
                                                   .smoothing = 1.1,
                                                   .flowing = true,
                                                   .calibrated = true,
                                                   .owner = both});
            Particles *s = &cloud->s;
            cloud->model.dissipates_rest = form != 2;
            cloud->model.keeps_pair_volume = form == 0;
            for (size_t i = 0; i < s->n; i++) {
                int place = 0;
                for (int d = 0; d < dim; d++) place += (int)floor(s->x[d][i] / 0.1);
                s->p[i] = place % 2 ? 400 : -400;
            }
            cloud_term(cloud, &pressure_gradient);
            cloud_term(cloud, &density_dissipation);
            for (size_t i = 0; i < s->n; i++) assert_true(s->rate[i] * s->p[i] < 0);
            cloud_free(cloud);
        }
}

/* With delta = 1, without gradients and without walls: what P3's continuity adds because of pressures, across any ratio of densities
 * and of speeds of sound. */
static void without_gradients_it_is_what_a_riemann_problem_dissipates(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, both);
        Particles *s = &cloud->s;
        double *at_rest = malloc(s->n * sizeof *at_rest), size = 0;
        assert_non_null(at_rest);
        cloud->model.phase[1].c *= 2.5;
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) s->v[d][i] = 0;
        cloud_term(cloud, &riemann_density);
        for (size_t i = 0; i < s->n; i++) {
            at_rest[i] = s->rate[i];
            size = fmax(size, fabs(at_rest[i]));
        }
        cloud->model.delta = 1;
        cloud->model.dissipates_rest = false;
        cloud_term(cloud, &density_dissipation);
        /* The Riemann terms' softened direction is off by 1e-12. */
        for (size_t i = 0; i < s->n; i++) assert_close(s->rate[i], at_rest[i], 1e-11 * size);
        assert_true(size > 1);
        free(at_rest);
        cloud_free(cloud);
    }
}

/* With velocities: P3's continuity is P1's by impedances and that dissipation. */
static void riemann_continuity_is_the_average_by_density_and_dissipation(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, both);
        Particles *s = &cloud->s;
        double *all = malloc(s->n * sizeof *all), size = 0;
        assert_non_null(all);
        cloud_term(cloud, &riemann_density);
        for (size_t i = 0; i < s->n; i++) {
            all[i] = s->rate[i];
            size = fmax(size, fabs(all[i]));
        }
        cloud->model.delta = 1;
        cloud->model.dissipates_rest = false;
        cloud->model.density_average = 1;
        const Pass pass = {"both", .terms = {&continuity, &density_dissipation}};
        particles_changed(s, ON_ALL, ALL_FIELDS);
        pass_run(&pass, s, &cloud->nb, &cloud->model, 1);
        for (size_t i = 0; i < s->n; i++) assert_close(s->rate[i], all[i], 1e-11 * size);
        free(all);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_of_linear_pressures_are_exact_everywhere),
        cmocka_unit_test(gradients_are_exact_in_corners_too),
        cmocka_unit_test(lonely_particles_have_no_wild_gradient),
        cmocka_unit_test(rates_are_those_of_the_paper_in_all_three_forms),
        cmocka_unit_test(a_linear_pressure_dissipates_nothing),
        cmocka_unit_test(closing_pairs_of_a_fluid_that_fills_resist),
        cmocka_unit_test(what_fills_takes_no_more_room_than_there_is),
        cmocka_unit_test(the_lightest_fluid_fills_and_resists_by_how_light_it_is),
        cmocka_unit_test(pairs_keep_their_volume),
        cmocka_unit_test(beside_a_gas_no_difference_grows),
        cmocka_unit_test(checkerboards_are_damped),
        cmocka_unit_test(without_gradients_it_is_what_a_riemann_problem_dissipates),
        cmocka_unit_test(riemann_continuity_is_the_average_by_density_and_dissipation),
    };
    return cmocka_run_group_tests_name("dissipation", tests, NULL, NULL);
}
