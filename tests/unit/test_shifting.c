/* SPDX-License-Identifier: BSD-3-Clause */
/* Shifting goes where fewer particles are and nowhere on a lattice, not through interfaces nor out of a free surface, no farther than a tenth of a
 * spacing, as fast as neighbours move past each other, and takes along what a linear field has at the new place. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static void cloud_shift(Cloud *cloud)
{
    cloud_term(cloud, &concentration);
    cloud_term(cloud, &shifting);
    local_run(&shifted_position, &cloud->s, &cloud->model, cloud->threads);
}

/* Is particle i listed beside one of another fluid? */
static bool is_mixed(const Cloud *cloud, size_t i)
{
    const Particles *s = &cloud->s;
    const uint32_t *list = neighbours_of(&cloud->nb, i);
    for (size_t k = 0; k < cloud->nb.end[i][END_FLUID]; k++)
        if (s->phase[list[k]] != s->phase[i]) return true;
    return false;
}

static int both(const double x[3])
{
    return x[1] < 0.45 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static int tank(const double x[3])
{
    return x[1] < 0.25 ? CLOUD_WALL : both(x);
}

/* Stirred, with normals at the interface. */
static Cloud *stirred_of(size_t across, int dim, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {across, across, 8},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .smoothing = 1.6,
                                           .periodic = {false, false, true},
                                           .flowing = true,
                                           .calibrated = true,
                                           .owner = owner});
    cloud->model.phase[CLOUD_AIR].c = 10; /* another than in water */
    cloud_stir(cloud, 15);
    cloud_term(cloud, &corrected_normal);
    return cloud;
}

static Cloud *stirred(int dim, int (*owner)(const double x[3]))
{
    return stirred_of(10, dim, owner);
}

/* Positions, velocities and densities before the term: [7][n]. */
typedef struct Before {
    double *of[7];
} Before;

static Before before_of(const Particles *s)
{
    Before before;
    for (int k = 0; k < 7; k++) {
        const double *field = k < 3 ? s->x[k] : k < 6 ? s->v[k - 3] : s->rho;
        before.of[k] = calloc(s->n, sizeof(double));
        assert_non_null(before.of[k]);
        if (field) memcpy(before.of[k], field, s->n * sizeof(double));
    }
    return before;
}

static void before_free(Before *before)
{
    for (int k = 0; k < 7; k++) free(before->of[k]);
}

static void shifts_are_those_of_the_paper_in_both_forms(void **state)
{
    (void)state;
    for (int way = 0; way < 8; way++) {
        const int dim = way & 1 ? 3 : 2;
        const bool along = way & 2;
        Cloud *cloud = stirred(dim, tank), *old = stirred(dim, tank);
        Particles *s = &cloud->s;
        const Particles *o = &old->s;
        cloud->model.shifts_along_interfaces = along;
        if (way & 4) cloud->model.dt = 0.05; /* so far that it is cut off */
        cloud_shift(cloud);
        size_t cut = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            double dx[3] = {0}, fastest = 0, size = 0, through = 0, dv[4] = {0};
            for (size_t j = 0; j < o->n; j++) {
                const CloudPair pair = cloud_pair(old, i, j);
                double v2 = 0;
                for (int d = 0; d < dim && j != i; d++) {
                    dx[d] += cloud_volume(old, j) * pair.F * pair.dx[d];
                    v2 += (o->v[d][j] - o->v[d][i]) * (o->v[d][j] - o->v[d][i]);
                }
                const bool counts = j < particles_fluid(o) && (!along || o->phase[j] == o->phase[i]);
                if (counts && pair.F < 0) fastest = fmax(fastest, v2);
            }
            for (int d = 0; d < dim; d++) {
                dx[d] *= -2 * cloud->model.kernel.h * sqrt(fastest) * cloud->model.dt;
                size += dx[d] * dx[d];
            }
            size = sqrt(size);
            cut += size > 0.01;
            for (int d = 0; d < dim; d++) {
                dx[d] *= fmin(1, 0.01 / size);
                through += dx[d] * o->normal[d][i];
            }
            for (int d = 0; d < dim && along; d++) dx[d] -= through * o->normal[d][i];
            for (size_t j = 0; j < particles_fluid(o); j++) {
                if (j == i || (along && o->phase[j] != o->phase[i])) continue;
                const CloudPair pair = cloud_pair(old, i, j);
                double c = 0;
                for (int d = 0; d < dim; d++) c += dx[d] * pair.F * pair.dx[d] * cloud_volume(old, j);
                for (int d = 0; d < dim; d++) dv[d] += c * (o->v[d][j] - o->v[d][i]);
                dv[3] += c * (o->rho[j] - o->rho[i]);
            }
            for (int d = 0; d < dim; d++) {
                assert_close(s->x[d][i], o->x[d][i] + dx[d], 1e-14);
                assert_close(s->v[d][i], o->v[d][i] + dv[d], 1e-13);
            }
            assert_close(s->rho[i], o->rho[i] + dv[3], 1e-13 * 1000);
        }
        assert_true((cut > 20) == (way & 4 ? true : false));
        cloud_free(cloud);
        cloud_free(old);
    }
}

static void even_particles_and_particles_at_rest_stay(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                               .dx = 0.1,
                                               .n = {10, 9, 8},
                                               .skin = 0.3,
                                               .periodic = {true, true, true},
                                               .flowing = true,
                                               .owner = both});
        Particles *s = &cloud->s;
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) s->v[d][i] = 3 + (double)(i % 5);
        Before before = before_of(s);
        cloud_shift(cloud);
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) assert_close(s->x[d][i], before.of[d][i], 1e-15); /* rounding of 1 */
        before_free(&before);
        cloud_free(cloud);

        cloud = stirred(dim, tank);
        s = &cloud->s;
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) s->v[d][i] = d == 0 ? 7 : 0; /* at rest, as seen by who drifts */
        before = before_of(s);
        cloud_shift(cloud);
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) assert_true(s->x[d][i] == before.of[d][i]);
        before_free(&before);
        cloud_free(cloud);
    }
}

static int with_a_hole(const double x[3])
{
    return fabs(x[0] - 0.45) < 0.01 && fabs(x[1] - 0.55) < 0.01 ? CLOUD_NOTHING : CLOUD_WATER;
}

static void particles_beside_a_void_move_into_it(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                               .dx = 0.1,
                                               .n = {10, 10, 8},
                                               .skin = 0.3,
                                               .smoothing = 1.6,
                                               .periodic = {true, true, true},
                                               .flowing = true,
                                               .owner = with_a_hole});
        Particles *s = &cloud->s;
        for (size_t i = 0; i < s->n; i++) s->v[dim - 1][i] = i % 2 ? -2 : -3; /* whichever way they go */
        Before before = before_of(s);
        cloud_shift(cloud);
        size_t around = 0;
        for (size_t i = 0; i < s->n; i++) {
            const double to[2] = {0.45 - before.of[0][i], 0.55 - before.of[1][i]}, r = hypot(to[0], to[1]);
            if (r > 0.15) continue;
            const double moved = (s->x[0][i] - before.of[0][i]) * to[0] + (s->x[1][i] - before.of[1][i]) * to[1];
            assert_true(moved / r > 1e-5);
            around++;
        }
        assert_int_equal(around, dim == 2 ? 8 : 64);
        before_free(&before);
        cloud_free(cloud);
    }
}

/* Beside an interface only along it; P2's original goes through. */
static void nothing_moves_through_an_interface(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int original = 0; original < 2; original++) {
            Cloud *cloud = stirred(dim, both);
            Particles *s = &cloud->s;
            cloud->model.shifts_along_interfaces = !original;
            Before before = before_of(s);
            cloud_shift(cloud);
            size_t beside = 0, crossing = 0;
            double along = 0;
            for (size_t i = 0; i < s->n; i++) {
                double through = 0, moved = 0, n2 = 0;
                for (int d = 0; d < dim; d++) {
                    const double dx = s->x[d][i] - before.of[d][i];
                    through += dx * s->normal[d][i];
                    moved += dx * dx;
                    n2 += s->normal[d][i] * s->normal[d][i];
                }
                if (n2 < 0.5) continue;
                beside++;
                crossing += fabs(through) > 1e-15; /* rounding of positions up to 1 */
                along = fmax(along, sqrt(moved));
            }
            assert_true(beside > 30 && along > 1e-5);
            if (original) assert_true(crossing > beside / 2);
            else assert_int_equal(crossing, 0);
            before_free(&before);
            cloud_free(cloud);
        }
}

/* A gas that fills what room there is moves through the interface, and keeps what it has. */
static void a_gas_that_fills_goes_where_there_is_room(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, both);
    Particles *s = &cloud->s;
    cloud->model.shifts_along_interfaces = cloud->model.phase[CLOUD_AIR].fills = true;
    Before before = before_of(s);
    cloud_shift(cloud);
    size_t crossing[2] = {0}, beside[2] = {0};
    for (size_t i = 0; i < s->n; i++) {
        double through = 0, n2 = 0;
        for (int d = 0; d < 2; d++) {
            through += (s->x[d][i] - before.of[d][i]) * s->normal[d][i];
            n2 += s->normal[d][i] * s->normal[d][i];
            if (s->phase[i] == CLOUD_AIR) assert_true(s->v[d][i] == before.of[3 + d][i]);
        }
        beside[s->phase[i]] += n2 > 0.5;
        crossing[s->phase[i]] += n2 > 0.5 && fabs(through) > 1e-15;
        if (s->phase[i] == CLOUD_AIR) assert_true(s->rho[i] == before.of[6][i]);
    }
    assert_int_equal(crossing[CLOUD_WATER], 0);
    assert_true(beside[CLOUD_AIR] > 5 && crossing[CLOUD_AIR] > beside[CLOUD_AIR] / 2);
    before_free(&before);
    cloud_free(cloud);
}

/* Ten times as strongly as others a gas, a light liquid at least five times; steps are so short that no bound is met. */
static void fluids_that_fill_are_shifted_by_how_light_they_are(void **state)
{
    (void)state;
    static const double resists[] = {0, 0, 0.5, 1}, times[] = {1, 5, 7.5, 10};
    double *first = NULL;
    for (int way = 0; way < 4; way++) {
        Cloud *cloud = stirred(2, both);
        Particles *s = &cloud->s;
        size_t within = 0;
        cloud->model.dt *= 1e-4;
        cloud->model.shifts_along_interfaces = true;
        cloud->model.phase[CLOUD_AIR].fills = way > 0;
        cloud->model.phase[CLOUD_AIR].resists = resists[way];
        Before before = before_of(s);
        cloud_shift(cloud);
        if (!first) first = calloc(s->n, sizeof *first);
        for (size_t i = 0; i < s->n; i++) {
            const double gone = s->x[0][i] - before.of[0][i];
            if (s->phase[i] != CLOUD_AIR || s->normal[0][i] != 0 || s->normal[1][i] != 0) continue;
            if (way == 0) first[i] = gone;
            assert_close(gone, times[way] * first[i], 1e-14); /* rounding of places */
            within += fabs(first[i]) > 1e-11;
        }
        assert_true(within > 5);
        before_free(&before);
        cloud_free(cloud);
    }
    free(first);
}

static int half_full(const double x[3])
{
    return x[1] < 1.6 ? CLOUD_WATER : CLOUD_NOTHING;
}

/* Where the kernel is not full, of a domain that is not; in one that fluids fill there is no free surface. */
static void nothing_moves_out_of_a_free_surface(void **state)
{
    (void)state;
    for (int filled = 0; filled < 2; filled++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2,
                                               .dx = 0.1,
                                               .n = {12, 24},
                                               .jitter = 0.2,
                                               .skin = 0.3,
                                               .smoothing = 1.6,
                                               .periodic = {true, false, false},
                                               .flowing = true,
                                               .calibrated = true,
                                               .owner = half_full});
        Particles *s = &cloud->s;
        cloud->model.filled = filled;
        cloud_stir(cloud, 15);
        cloud_term(cloud, &corrected_normal);
        cloud_term(cloud, &shepard_sum);
        Before before = before_of(s);
        cloud_shift(cloud);
        size_t near = 0, inside = 0;
        for (size_t i = 0; i < s->n; i++) {
            bool surface = s->shepard[i] < 0.85;
            for (size_t j = 0; j < s->n; j++)
                surface |= j != i && cloud_pair(cloud, i, j).F < 0 && s->shepard[j] < 0.85;
            const bool moved = s->x[0][i] != before.of[0][i] || s->x[1][i] != before.of[1][i];
            if (surface && !filled) assert_false(moved);
            near += surface && moved;
            inside += !surface && moved;
        }
        assert_true(filled ? near > 20 : inside > 5);
        before_free(&before);
        cloud_free(cloud);
    }
}

/* As far as sums without M have it: they go where neighbours are missing, and what is missing of the sums is missing of the differences. */
static void a_linear_field_is_carried(void **state)
{
    (void)state;
    static const double slope[4][3] = {{1, -2, 0.5}, {0.7, 1.3, -1}, {2, 0.4, -0.6}, {0.3, 0.2, -0.25}};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred_of(20, dim, both);
        Particles *s = &cloud->s;
        cloud->model.periodic = false; /* a linear field is not */
        cloud->model.period[2] = cloud->model.frequency[2] = 0;
        assert_int_equal(cloud_build(cloud), MNS_OK);
        cloud_term(cloud, &corrected_normal);
        cloud_term(cloud, &shepard_sum);
        for (size_t i = 0; i < s->n; i++) {
            double field[4] = {4, 4, 4, 1};
            for (int k = 0; k < 4; k++)
                for (int e = 0; e < dim; e++) field[k] += slope[k][e] * s->x[e][i];
            for (int d = 0; d < dim; d++) s->v[d][i] = field[d];
            s->rho[i] = cloud->model.phase[s->phase[i]].rho0 * field[3];
        }
        Before before = before_of(s);
        cloud_shift(cloud);
        double done[2][2] = {{0}},
               wanted[2][2] = {{0}}; /* of velocity and density, inside and beside the other fluid */
        for (size_t i = 0; i < s->n; i++) {
            double due[4] = {0}, changed[4] = {0};
            for (int k = 0; k < 4; k++)
                for (int e = 0; e < dim; e++) due[k] += slope[k][e] * (s->x[e][i] - before.of[e][i]);
            for (int d = 0; d < dim; d++) changed[d] = s->v[d][i] - before.of[3 + d][i];
            changed[3] = (s->rho[i] - before.of[6][i]) / cloud->model.phase[s->phase[i]].rho0;
            const bool beside = is_mixed(cloud, i);
            if (!beside && s->shepard[i] < 0.9) continue; /* at the cloud's edge */
            for (int k = 0; k < 4; k++) {
                if (k == 2 && dim == 2) continue;
                done[k == 3][beside] += changed[k] * due[k];
                wanted[k == 3][beside] += due[k] * due[k];
            }
        }
        for (int k = 0; k < 2; k++)
            for (int l = 0; l < 2; l++) {
                assert_less(0.5, done[k][l] / wanted[k][l]);
                assert_less(done[k][l] / wanted[k][l], 1);
            }
        before_free(&before);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shifts_are_those_of_the_paper_in_both_forms),
        cmocka_unit_test(even_particles_and_particles_at_rest_stay),
        cmocka_unit_test(particles_beside_a_void_move_into_it),
        cmocka_unit_test(nothing_moves_through_an_interface),
        cmocka_unit_test(a_gas_that_fills_goes_where_there_is_room),
        cmocka_unit_test(fluids_that_fill_are_shifted_by_how_light_they_are),
        cmocka_unit_test(nothing_moves_out_of_a_free_surface),
        cmocka_unit_test(a_linear_field_is_carried),
    };
    return cmocka_run_group_tests_name("shifting", tests, NULL, NULL);
}
