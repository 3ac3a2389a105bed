/* SPDX-License-Identifier: BSD-3-Clause */
/* Gas that particles do not resolve has the pressure of the liquid around it besides its own, and resolved gas its own alone. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

static double bubble_size; /* half its edge, in spacings; the owner of a point has no argument for it */
static double apart;       /* another such bubble is this many spacings away along x; 0: there is none */

static int bubble(const double x[3])
{
    for (int k = 0; k < 2; k++) {
        double most = fabs(x[0] - 0.55 - 0.1 * apart * k); /* around the lattice's point 5 */
        for (int d = 1; d < 3; d++)
            if (x[d] > 0) most = fmax(most, fabs(x[d] - 0.55));
        if (most < 0.1 * bubble_size) return CLOUD_AIR;
    }
    return CLOUD_WATER;
}

static Cloud *cloud_with_bubble(int dim, double size)
{
    bubble_size = size;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {11, 11, 11}, .owner = bubble, .skin = 0.2});
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++) s->p[i] = i < s->begin[GROUP_SUMMATION] ? 700 + 300 * s->x[0][i] : 5;
    return cloud;
}

static void a_lone_particle_takes_the_pressure_around_it(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_with_bubble(dim, 0.5);
        Particles *s = &cloud->s;
        const size_t i = s->begin[GROUP_SUMMATION];
        assert_int_equal(s->begin[GROUP_WALL] - i, 1);
        cloud_term(cloud, &bubble_pressure);
        assert_close(s->p[i], 5 + 700 + 300 * 0.55, 1e-10); /* the mean of a linear field, about the middle: rounding */
        for (size_t k = 0; k < i; k++) assert_true(s->p[k] == 700 + 300 * s->x[0][k]);
        cloud_free(cloud);
    }
}

static void resolved_gas_keeps_its_own(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int size = 1; size <= 3; size++) {
            Cloud *cloud = cloud_with_bubble(dim, size + 0.5);
            const Particles *s = &cloud->s;
            cloud_term(cloud, &bubble_pressure);
            assert_true(s->begin[GROUP_WALL] - s->begin[GROUP_SUMMATION] >= 9);
            for (size_t i = s->begin[GROUP_SUMMATION]; i < s->begin[GROUP_WALL]; i++) assert_true(s->p[i] == 5);
            cloud_free(cloud);
        }
}

/* Two lone particles, which see more or less of each other: against brute force. */
static void it_fades_in_with_the_share_of_liquid(void **state)
{
    (void)state;
    int faded = 0;
    for (int dim = 2; dim <= 3; dim++)
        for (int gap = 1; gap <= 3; gap++) {
            apart = gap;
            Cloud *cloud = cloud_with_bubble(dim, 0.5);
            Particles *s = &cloud->s;
            const size_t i = s->begin[GROUP_SUMMATION];
            double all = 0, liquid = 0, pressure = 0;
            for (size_t j = 0; j < s->n; j++) {
                const double weight = j == i ? 0 : cloud_pair(cloud, i, j).W * s->vol[j];
                all += weight;
                if (j >= i) continue;
                liquid += weight;
                pressure += weight * s->p[j];
            }
            const double share = liquid / all, chi = share > 0.9 ? 10 * (share - 0.9) : 0;
            faded += chi > 0.1 && chi < 0.95;
            cloud_term(cloud, &bubble_pressure);
            assert_close(s->p[i], 5 + chi * pressure / liquid, 1e-9);
            cloud_free(cloud);
        }
    apart = 0;
    assert_true(faded > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lone_particle_takes_the_pressure_around_it),
        cmocka_unit_test(resolved_gas_keeps_its_own),
        cmocka_unit_test(it_fades_in_with_the_share_of_liquid),
    };
    return cmocka_run_group_tests_name("bubble", tests, NULL, NULL);
}
