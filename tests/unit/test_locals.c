/* SPDX-License-Identifier: BSD-3-Clause */
/* Summed densities and the rules for single particles: each formula once, on its own groups and on no other. */
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

static int tank(const double x[3])
{
    if (x[1] < 0.3) return CLOUD_WALL;
    return x[1] < 0.5 + 0.3 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(void)
{
    Cloud *cloud =
        cloud_new(&(CloudSetup){.dim = 3, .dx = 0.1, .n = {8, 9, 6}, .jitter = 0.2, .skin = 0.3, .owner = tank});
    cloud_stir(cloud, 14);
    for (size_t i = 0; i < cloud->s.n; i++) cloud->s.rate[i] = 100 + (double)i;
    return cloud;
}

static void number_density_counts_the_particle_itself_and_all_around(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud =
            cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {8, 9, 6}, .jitter = 0.2, .skin = 0.3, .owner = tank});
        const Particles *s = &cloud->s;
        cloud_term(cloud, &number_density);
        for (size_t i = 0; i < s->n; i++) {
            double sum = 0;
            for (size_t j = 0; j < s->n; j++) sum += cloud_pair(cloud, i, j).W; /* W(0) with j = i */
            const bool air = i >= s->begin[GROUP_SUMMATION] && i < s->begin[GROUP_WALL];
            assert_close(s->rate[i], air ? sum : 0, 1e-13 * sum); /* rounding */
        }
        cloud_free(cloud);
    }
}

static void summed_density_is_mass_times_number_density(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    const double water = s->rho[0], wall = s->rho[s->n - 1];
    local_run(&summed_density, s, &cloud->model, 2);
    for (size_t i = s->begin[GROUP_SUMMATION]; i < s->begin[GROUP_WALL]; i++)
        assert_true(s->rho[i] == s->m[i] * (100 + (double)i));
    assert_true(s->rho[0] == water && s->rho[s->n - 1] == wall);
    cloud_free(cloud);
}

static void continuity_advances_by_one_step(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    const size_t water = s->begin[GROUP_SUMMATION];
    const double first = s->rho[0], last = s->rho[water - 1], air = s->rho[water], wall = s->rho[s->n - 1];
    cloud->model.dt = 0.125;
    local_run(&advance_density, s, &cloud->model, 2);
    assert_true(s->rho[0] == first + 0.125 * 100);
    assert_true(s->rho[water - 1] == last + 0.125 * (99 + (double)water));
    assert_true(s->rho[water] == air && s->rho[s->n - 1] == wall);
    cloud_free(cloud);
}

static void shepard_sums_follow_the_densities_that_come(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    const size_t last = s->begin[GROUP_SUMMATION] - 1;
    const double rho = s->rho[last], Gamma = s->shepard[last] = 0.97, air = s->shepard[last + 1];
    cloud->model.dt = 0.125;
    local_run(&advance_shepard_sum, s, &cloud->model, 2);
    local_run(&advance_density, s, &cloud->model, 2);
    assert_close(s->shepard[last] * s->rho[last], Gamma * rho, 1e-12 * rho);
    assert_true(s->shepard[last + 1] == air);
    cloud_free(cloud);
}

static int all_water(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : CLOUD_WATER;
}

/* By one pressure for all, and only where a space is closed and full of liquids. */
static void liquids_in_a_closed_space_keep_its_volume(void **state)
{
    (void)state;
    for (int closed = 0; closed < 2; closed++) {
        Cloud *cloud = cloud_new(
            &(CloudSetup){.dim = 2, .dx = 0.1, .n = {80, 83}, .jitter = 0.2, .skin = 0.3, .owner = all_water});
        Particles *s = &cloud->s;
        const size_t n = particles_fluid(s), half = n / 2;
        assert_true(n > 4096); /* more than one block */
        cloud_stir(cloud, 5);
        cloud->model.closed = closed;
        cloud->model.phase[1].c = 40;
        cloud->model.phase[1].summation = false;
        double volume = 0;
        for (size_t i = 0; i < n; i++) {
            s->phase[i] = i >= half;
            s->rho[i] *= 1.01;
            volume += s->m[i] / s->rho[i];
        }
        const double first = s->rho[0], last = s->rho[n - 1], wall = s->rho[n];
        assert_true(fabs(volume / ((double)n * cloud->model.cell_volume) - 1) > 1e-3);
        local_run(&closed_volume, s, &cloud->model, 3);
        double after = 0;
        for (size_t i = 0; i < n; i++) after += s->m[i] / s->rho[i];
        /* One step of Newton's, of a change of up to 1 %. */
        assert_close(after, closed ? (double)n * cloud->model.cell_volume : volume, closed ? 2e-4 * volume : 1e-12);
        const double dp = (s->rho[0] - first) * 20 * 20;
        assert_close((s->rho[n - 1] - last) * 40 * 40, dp, 1e-9 * 1000 * 400); /* rounding */
        assert_true(closed ? dp != 0 : dp == 0);
        assert_true(s->rho[n] == wall);
        cloud_free(cloud);
    }
}

static void pressure_is_linear_in_density_with_each_fluids_own_constants(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    cloud->model.phase[0].c = 20;
    cloud->model.phase[1].c = 7;
    const double wall = s->p[s->n - 1];
    local_run(&linear_pressure, s, &cloud->model, 2);
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const double c = s->phase[i] == 0 ? 20 : 7, rho0 = s->phase[i] == 0 ? 1000 : 1;
        assert_close(s->p[i], c * c * (s->rho[i] - rho0), 1e-14 * c * c * rho0); /* rounding */
    }
    assert_true(s->p[s->n - 1] == wall);
    cloud_free(cloud);
}

/* Of fluids. Walls have their cells of the lattice and no impedance, whatever is written there. */
static void volumes_and_impedances_are_those_of_density_and_mass(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    cloud->model.phase[1].c = 7;
    for (size_t i = particles_fluid(s); i < s->n; i++) s->rho[i] = s->m[i] = (double)i;
    for (size_t i = 0; i < s->n; i++) {
        const bool wall = i >= particles_fluid(s);
        const double c = s->phase[i] == 0 ? 20 : 7;
        assert_true(cloud_volume(cloud, i) == (wall ? cloud->model.cell_volume : s->m[i] / s->rho[i]));
        assert_true(cloud_impedance(cloud, i) == (wall ? 0 : s->rho[i] * c));
    }
    cloud_free(cloud);
}

static void accelerations_begin_with_gravity_and_nothing(void **state)
{
    (void)state;
    Cloud *cloud = stirred();
    Particles *s = &cloud->s;
    for (int d = 0; d < 3; d++) {
        cloud->model.gravity[d] = 3 - 2 * d;
        for (size_t i = 0; i < s->n; i++) s->a[d][i] = s->b[d][i] = 77;
    }
    local_run(&body_force, s, &cloud->model, 2);
    for (int d = 0; d < 3; d++)
        for (size_t i = 0; i < s->n; i++) {
            const bool fluid = i < particles_fluid(s);
            assert_true(s->a[d][i] == (fluid ? 3 - 2 * d : 77));
            assert_true(s->b[d][i] == 77); /* the last step's, which this one moves with */
        }
    cloud_free(cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(number_density_counts_the_particle_itself_and_all_around),
        cmocka_unit_test(summed_density_is_mass_times_number_density),
        cmocka_unit_test(continuity_advances_by_one_step),
        cmocka_unit_test(shepard_sums_follow_the_densities_that_come),
        cmocka_unit_test(liquids_in_a_closed_space_keep_its_volume),
        cmocka_unit_test(pressure_is_linear_in_density_with_each_fluids_own_constants),
        cmocka_unit_test(volumes_and_impedances_are_those_of_density_and_mass),
        cmocka_unit_test(accelerations_begin_with_gravity_and_nothing),
    };
    return cmocka_run_group_tests_name("locals", tests, NULL, NULL);
}
