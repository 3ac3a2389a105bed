/* SPDX-License-Identifier: BSD-3-Clause */
/* What P3's v* leaves alone: gradients of linear pressures are exact, of each fluid for itself, and such pressures drive no volume; a gas keeps all, and
 * so does what is no liquid at rest. What is left of a difference is never more, nor of the other sign. Water under a free surface keeps its level. */
#include "sim/terms/slope.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include "tests/support/sims.h"

static int pool(const double x[3])
{
    if (x[1] < 0.35) return CLOUD_WALL;
    return x[1] < 0.8 ? CLOUD_WATER : CLOUD_NOTHING;
}

static const double ALONG[3] = {300, -500, 200};

/* At rest, of pressures that are linear; the second fluid is a gas to the first if it is that light. */
static Cloud *linear(int dim, double light, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_reconstructing(dim, light, owner);
    Particles *s = &cloud->s;
    cloud->model.spared = SPARED_SLOPES;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        s->p[i] = 7;
        for (int d = 0; d < dim; d++) s->p[i] += ALONG[d] * s->x[d][i];
    }
    return cloud;
}

static void gradients_of_linear_pressures_are_exact_in_each_fluid(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = linear(dim, 500, cloud_two_fluids);
        const Particles *s = &cloud->s;
        for (size_t i = 0; i < particles_fluid(s); i++) /* that of the other fluid is another */
            if (s->phase[i] == CLOUD_AIR) s->p[i] = 900 - 2 * s->p[i];
        cloud_term(cloud, &pressure_slope);
        size_t exact = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            bool well = true;
            for (int d = 0; d < dim; d++)
                well = well && fabs(s->gradient[d][i] - (s->phase[i] == CLOUD_AIR ? -2 : 1) * ALONG[d]) < 1e-6;
            exact += well;
        }
        assert_true((double)exact > 0.97 * (double)particles_fluid(s)); /* but where there are hardly any neighbours */
        cloud_free(cloud);
    }
}

/* Rates of fluid at rest, which are of pressures alone. */
static void drive(Cloud *cloud, Spared spared)
{
    cloud->model.spared = spared;
    cloud_term(cloud, &pressure_slope);
    cloud_term(cloud, &riemann_density);
}

static double largest_rate(const Cloud *cloud, unsigned fluid)
{
    double most = 0;
    for (size_t i = 0; i < particles_fluid(&cloud->s); i++)
        if (cloud->s.phase[i] == fluid && cloud_inner(cloud, i)) most = fmax(most, fabs(cloud->s.rate[i]));
    return most;
}

static void linear_pressures_drive_no_volume(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int two = 0; two < 2; two++) {
            Cloud *cloud = linear(dim, 500, two ? cloud_two_fluids : NULL);
            drive(cloud, SPARED_NOTHING);
            const double before[2] = {largest_rate(cloud, 0), largest_rate(cloud, 1)};
            drive(cloud, SPARED_SLOPES);
            for (unsigned k = 0; k <= (unsigned)two; k++) {
                assert_true(before[k] > 1e-3);
                assert_less(largest_rate(cloud, k), 1e-9 * before[k]);
            }
            cloud_free(cloud);
        }
}

static void a_gas_keeps_all_of_it(void **state)
{
    (void)state;
    Cloud *cloud = linear(2, 1, cloud_two_fluids);
    const Particles *s = &cloud->s;
    double *before = calloc(s->n, sizeof *before);
    size_t alone = 0, beside = 0;
    assert_non_null(before);
    drive(cloud, SPARED_NOTHING);
    for (size_t i = 0; i < s->n; i++) before[i] = s->rate[i];
    drive(cloud, SPARED_SLOPES);
    for (size_t i = 0; i < s->n; i++) {
        if (s->phase[i] != CLOUD_AIR) continue;
        for (int d = 0; d < 2; d++) assert_true(s->gradient[d][i] == 0);
        if (cloud->nb.has[i] & LIST_OTHERS) {
            beside += s->rate[i] != before[i]; /* of a pair with water, that takes its half */
            continue;
        }
        alone++;
        assert_true(s->rate[i] == before[i]);
    }
    assert_true(alone > 10 && beside > 5);
    free(before);
    cloud_free(cloud);
}

static void what_is_left_is_never_more_nor_of_the_other_sign(void **state)
{
    (void)state;
    uint64_t seed = 3;
    size_t none = 0, whole = 0, some = 0;
    for (int k = 0; k < 1000; k++) {
        const double all = cloud_noise(&seed), left = left_beside(all, cloud_noise(&seed));
        assert_true(left * all >= 0 && fabs(left) <= fabs(all));
        none += left == 0;
        whole += left == all;
        some += left != 0 && left != all;
    }
    assert_true(none > 100 && whole > 100 && some > 100);
    assert_true(left_beside(0, 1) == 0 && left_beside(0, -1) == 0);
    assert_true(left_beside(3, 1) == 2 && left_beside(-3, -1) == -2);
}

/* Of one weight or the other way of the slope: a pool, at rest to its surface and on its floor. */
static void a_pool_at_rest_drives_no_volume(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = linear(dim, 500, pool);
            Particles *s = &cloud->s;
            const size_t n = particles_fluid(s);
            cloud->model.gravity[1] = -9.81;
            for (size_t i = 0; i < n; i++) s->p[i] = 9810 * (0.8 - s->x[1][i]);
            for (size_t w = n; w < s->n; w++) s->p_wall[0][w - n] = 9810 * (0.8 - s->x[1][w]);
            double most[2] = {0, 0};
            for (int on = 0; on < 2; on++) {
                drive(cloud, !on ? SPARED_NOTHING : k ? SPARED_SLOPES : SPARED_WEIGHT);
                for (size_t i = 0; i < n; i++) most[on] = fmax(most[on], fabs(s->rate[i]));
            }
            assert_true(most[0] > 1);
            assert_less(most[1], 1e-9 * most[0]);
            cloud_free(cloud);
        }
}

/* The weight is of a fluid's own pairs: those of two keep all. */
static void the_weight_is_of_pairs_of_one_fluid(void **state)
{
    (void)state;
    const Slope slope = {{0, -9810, 0}};
    const Slopes theirs = {{{0}}};
    const Pair pair = {.x = {0, -0.1, 0}, .p = 100};
    const How how = {.dim = 2};
    assert_true(pressure_beside(&slope, 1500, &pair, &theirs, 1, SPARED_WEIGHT, how, 0) == 1400);
    assert_close(pressure_beside(&slope, 1500, &pair, &theirs, 0, SPARED_WEIGHT, how, 0), 1400 - 981, 1e-9);
    assert_true(pressure_beside(&slope, 1500, &pair, &theirs, 0, SPARED_NOTHING, how, 0) == 1400);
}

/* Mean height of water that stands half as high as its tank is, at t, over that at the start. */
static double level_after(MnsReconstruction reconstruction, double t)
{
    MnsCase *c = case_blank(2, 20);
    c->max[1] = 1.5;
    c->scheme.smoothing = 1.6;
    c->scheme.riemann.reconstruction = reconstruction;
    case_set_text(&c->gravity[1], "-1");
    case_add_fluid(c, "water", 1, 14);
    case_set_text(&c->fluids[0].pressure, "hydrostatic");
    case_put_part(2, &c->fluids[0].shape, (MnsPart){.primitive = MNS_BOX, .b = {1, 1, 0}});
    case_add_wall(c, "tank");
    MnsPart *tank = case_put_part(2, &c->walls[0].shape, (MnsPart){.primitive = MNS_BOX, .b = {1, 2, 0}});
    tank->outside = true;
    MnsSim *sim = sim_of(c);
    const Particles *s = &sim->s;
    assert_false(sim->model.filled);
    double height[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        while (k && mns_sim_progress(sim).t < t) assert_int_equal(mns_sim_step(sim, t, NULL), MNS_OK);
        for (size_t i = 0; i < particles_fluid(s); i++) height[k] += s->x[1][i * s->x_step];
    }
    sim_done(sim, c);
    return height[1] / height[0] - 1;
}

static void water_under_a_free_surface_keeps_its_level(void **state)
{
    (void)state;
    static const MnsReconstruction ways[] = {MNS_RECONSTRUCTION_NONE, MNS_RECONSTRUCTION_VELOCITY,
                                             MNS_RECONSTRUCTION_BOTH};
    double rise[3];
    for (int k = 0; k < 3; k++) {
        rise[k] = level_after(ways[k], 4);
        print_message("level %+.4f\n", rise[k]);
    }
    assert_true(rise[0] > 1e-3);
    assert_less(fabs(rise[1]), 0.2 * rise[0]);
    assert_less(fabs(rise[2]), 0.2 * rise[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_of_linear_pressures_are_exact_in_each_fluid),
        cmocka_unit_test(linear_pressures_drive_no_volume),
        cmocka_unit_test(a_gas_keeps_all_of_it),
        cmocka_unit_test(what_is_left_is_never_more_nor_of_the_other_sign),
        cmocka_unit_test(a_pool_at_rest_drives_no_volume),
        cmocka_unit_test(the_weight_is_of_pairs_of_one_fluid),
        cmocka_unit_test(water_under_a_free_surface_keeps_its_level),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
