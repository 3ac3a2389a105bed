/* SPDX-License-Identifier: BSD-3-Clause */
/* Neighbour lists are what comparing every particle with every other gives, in one and the same order for any number of
 * threads, and building them again changes nothing. */
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static int three_kinds(const double x[3])
{
    if (x[1] < 0.2 + 0.1 * x[0]) return CLOUD_WALL;
    return x[0] + 0.3 * x[1] + 0.2 * x[2] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int group_of(const Particles *s, size_t i)
{
    return i < s->begin[1] ? GROUP_CONTINUITY : i < s->begin[2] ? GROUP_SUMMATION : GROUP_WALL;
}

/* Every list, or one of so many, against all other particles. */
static void assert_complete_of(const Cloud *cloud, size_t many)
{
    const Particles *s = &cloud->s;
    const double reach = cloud->model.kernel.support + cloud->model.skin;
    uint8_t *listed = malloc(s->n);
    size_t pairs = 0;
    assert_non_null(listed);
    for (size_t i = 0; i < s->n; i += many) {
        const uint32_t *list = neighbours_of(&cloud->nb, i);
        memset(listed, 0, s->n);
        const size_t n = cloud->nb.end[i][END_WALLS], fluid = cloud->nb.end[i][END_FLUID];
        for (size_t k = 0; k < n; k++) {
            assert_in_range(list[k], 0, s->n - 1);
            assert_true((group_of(s, list[k]) == GROUP_WALL) == (k >= fluid));
            if (k > 0) assert_true(group_of(s, list[k]) >= group_of(s, list[k - 1]));
            listed[list[k]]++;
        }
        for (size_t j = 0; j < s->n; j++) {
            double dx[3];
            const double r = cloud_distance(cloud, i, j, dx);
            const bool both_walls = group_of(s, i) == GROUP_WALL && group_of(s, j) == GROUP_WALL;
            if (fabs(r - reach) < 1e-12) continue; /* on the rim either answer is right */
            assert_int_equal(listed[j], i != j && r < reach && !both_walls);
            pairs += listed[j];
        }
    }
    if (many == 1) assert_int_equal(neighbours_pairs(&cloud->nb), pairs);
    free(listed);
}

/* If j is in the list of i, then i is in the list of j. */
static void assert_mutual(const Cloud *cloud)
{
    const Particles *s = &cloud->s;
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (size_t k = 0; k < cloud->nb.end[i][END_FLUID]; k++) {
            const uint32_t j = neighbours_of(&cloud->nb, i)[k], *its = neighbours_of(&cloud->nb, j);
            size_t q = 0;
            while (q < cloud->nb.end[j][END_FLUID] && its[q] != i) q++;
            assert_true(q < cloud->nb.end[j][END_FLUID]);
        }
}

static void assert_complete(const Cloud *cloud)
{
    assert_complete_of(cloud, 1);
}

static void assert_complete_for(CloudSetup setup)
{
    Cloud *cloud = cloud_new(&setup);
    assert_true(cloud->s.begin[GROUPS] > 20);
    assert_complete(cloud);
    cloud_free(cloud);
}

/* Sizes from the fewest cells that a period may have, three to a side, up to some. */
static void lists_are_complete_in_two_dimensions_periodic_or_not(void **state)
{
    (void)state;
    static const size_t sizes[][2] = {{6, 6}, {6, 9}, {9, 7}, {13, 21}, {24, 11}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (int periodic = 0; periodic < 4; periodic++)
            assert_complete_for((CloudSetup){.dim = 2,
                                             .dx = 0.07,
                                             .n = {sizes[k][0], sizes[k][1]},
                                             .periodic = {periodic & 1, periodic & 2},
                                             .jitter = 0.9,
                                             .skin = 0.3,
                                             .owner = three_kinds});
}

static void lists_are_complete_in_three_dimensions_periodic_or_not(void **state)
{
    (void)state;
    static const size_t sizes[][3] = {{6, 6, 6}, {6, 7, 10}, {11, 6, 8}, {9, 15, 7}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (int periodic = 0; periodic < 8; periodic++)
            assert_complete_for((CloudSetup){.dim = 3,
                                             .dx = 0.1,
                                             .n = {sizes[k][0], sizes[k][1], sizes[k][2]},
                                             .periodic = {periodic & 1, periodic & 2, periodic & 4},
                                             .jitter = 0.7,
                                             .skin = 0.3,
                                             .owner = three_kinds});
}

/* Borders of columns along both directions, the last columns with room to spare. */
static void lists_go_on_from_column_to_column(void **state)
{
    (void)state;
    for (int periodic = 0; periodic < 2; periodic++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 3,
                                               .dx = 0.1,
                                               .n = {42, 34, 2},
                                               .periodic = {periodic, !periodic, false},
                                               .jitter = 0.7,
                                               .skin = 0.1,
                                               .owner = three_kinds});
        const Grid *grid = &cloud->nb.grid;
        for (int d = 0; d < 2; d++) assert_in_range(grid->columns[d], 2, 3);
        assert_true(grid->columns[0] * grid->width[0] > grid->n[0] || grid->columns[1] * grid->width[1] > grid->n[1]);
        assert_complete(cloud);
        cloud_free(cloud);
    }
}

/* Of a grid that repeats itself, whose last column along x is one cell wide: two borders among five cells. */
static void runs_go_round_over_a_narrow_last_column(void **state)
{
    (void)state;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 3, .dx = 0.1, .n = {12, 11, 10}, .owner = NULL});
    const double distance = cloud->model.kernel.support, edge = distance / 2;
    static const int n[] = {553, 6, 4};
    for (int d = 0; d < 3; d++) {
        cloud->model.min[d] = 0;
        cloud->model.max[d] = cloud->model.period[d] = (n[d] + 1e-6) * edge;
    }
    const Grid grid = grid_make(&cloud->s, &cloud->model, distance, 1);
    assert_int_equal(grid.n[0], n[0]);
    assert_int_equal((grid.columns[0] - 1) * grid.width[0], n[0] - 1);
    uint8_t *seen = malloc(grid.cells);
    assert_non_null(seen);
    for (int x = 0; x < n[0]; x++) {
        Run runs[GRID_RUNS_MAX];
        const double at[] = {(x + 0.5) / grid.per_length[0], 0.5 * edge, 1.5 * edge};
        const int count = grid_runs(&grid, grid_cell(&grid, at), runs);
        memset(seen, 0, grid.cells);
        for (int k = 0; k < count; k++)
            for (size_t cell = runs[k].first; cell <= runs[k].last; cell++) seen[cell]++;
        for (int k = 0; k < 125; k++) {
            const int apart[] = {k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2};
            double beside[3], gap2 = 0;
            for (int d = 0; d < 3; d++) {
                const double gap = fmax(0, abs(apart[d]) - 1);
                beside[d] = at[d] + apart[d] * edge;
                gap2 += gap * gap;
            }
            const int times = seen[grid_cell(&grid, beside)];
            assert_in_range(times, gap2 < grid.ratio * grid.ratio, 1);
        }
    }
    free(seen);
    cloud_free(cloud);
}

static void particles_outside_the_domain_have_neighbours_too(void **state)
{
    (void)state;
    for (int periodic = 0; periodic < 8; periodic += 3)
        for (int dim = 2; dim <= 3; dim++)
            assert_complete_for((CloudSetup){.dim = dim,
                                             .dx = 0.1,
                                             .n = {9, 8, 7},
                                             .periodic = {periodic & 1, periodic & 2, periodic & 4},
                                             .jitter = 0.5,
                                             .outside = 1.7,
                                             .skin = 0.3,
                                             .owner = three_kinds});
}

static void a_wide_kernel_and_a_wide_skin_are_no_problem(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        assert_complete_for((CloudSetup){.dim = dim,
                                         .dx = 0.1,
                                         .n = {14, 13, 12},
                                         .jitter = 0.4,
                                         .smoothing = 2,
                                         .kernel = MNS_QUINTIC_SPLINE,
                                         .skin = 0,
                                         .owner = three_kinds});
        assert_complete_for((CloudSetup){.dim = dim,
                                         .dx = 0.1,
                                         .n = {11, 10, 12},
                                         .periodic = {true, false, true},
                                         .jitter = 0.4,
                                         .smoothing = 1.3,
                                         .skin = 2,
                                         .owner = three_kinds});
    }
}

/* One cell is the whole domain. */
static void a_domain_smaller_than_the_reach_is_searched_whole(void **state)
{
    (void)state;
    assert_complete_for((CloudSetup){.dim = 2, .dx = 0.1, .n = {30, 2}, .jitter = 0.4, .owner = NULL});
    assert_complete_for((CloudSetup){.dim = 3, .dx = 0.1, .n = {2, 14, 1}, .jitter = 0.4, .owner = NULL});
}

static void lone_fluids_need_no_other_group(void **state)
{
    (void)state;
    assert_complete_for((CloudSetup){.dim = 3, .dx = 0.1, .n = {7, 6, 5}, .jitter = 0.4, .owner = NULL});
}

/* All there is to compare: ids in the order of storage, ends, entries. */
static void assert_same_lists(const Cloud *a, const Cloud *b)
{
    assert_int_equal(a->s.n, b->s.n);
    assert_memory_equal(a->s.id, b->s.id, a->s.n * sizeof *a->s.id);
    assert_memory_equal(a->nb.end, b->nb.end, a->s.n * sizeof *a->nb.end);
    for (size_t i = 0; i < a->s.n; i++)
        assert_memory_equal(neighbours_of(&a->nb, i), neighbours_of(&b->nb, i),
                            a->nb.end[i][END_WALLS] * sizeof(uint32_t));
}

static void lists_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    CloudSetup setup = {.dim = 3,
                        .dx = 0.1,
                        .n = {12, 11, 13},
                        .periodic = {true, false, false},
                        .jitter = 0.6,
                        .outside = 0.3,
                        .skin = 0.3,
                        .owner = three_kinds};
    Cloud *one = cloud_new(&setup);
    static const int threads[] = {2, 3, 7};
    for (size_t k = 0; k < 3; k++) {
        setup.threads = threads[k];
        Cloud *more = cloud_new(&setup);
        assert_same_lists(one, more);
        cloud_free(more);
    }
    cloud_free(one);
}

static void building_again_from_the_same_positions_changes_nothing(void **state)
{
    (void)state;
    for (int threads = 1; threads <= 3; threads += 2) {
        const CloudSetup setup = {.dim = 2,
                                  .dx = 0.1,
                                  .n = {31, 17},
                                  .jitter = 0.6,
                                  .outside = 0.2,
                                  .skin = 0.3,
                                  .owner = three_kinds,
                                  .threads = threads};
        Cloud *once = cloud_new(&setup), *twice = cloud_new(&setup);
        for (int k = 0; k < 3; k++) assert_int_equal(cloud_build(twice), MNS_OK);
        assert_same_lists(once, twice);
        cloud_free(once);
        cloud_free(twice);
    }
}

/* Lists of another storage order hold the same particles: order comes from it, contents do not. */
static void particles_keep_their_own_values_when_sorted(void **state)
{
    (void)state;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 3, .dx = 0.1, .n = {8, 9, 7}, .skin = 0.3, .owner = three_kinds});
    Particles *s = &cloud->s;
    const size_t first_wall = particles_fluid(s);
    uint64_t seed = 4;
    for (size_t i = 0; i < s->n; i++) {
        const double mark = s->id[i];
        for (int d = 0; d < 3; d++) {
            s->x[d][i] = 0.4 + 0.4 * cloud_noise(&seed); /* to sort anew */
            s->v[d][i] = mark + 0.1 * (d + 1);
            s->a[d][i] = mark + 0.2 * (d + 1);
            s->b[d][i] = mark + 0.01 * (d + 1);
        }
        s->m[i] = mark + 0.31;
        s->rho[i] = mark + 0.32;
        s->p[i] = mark + 0.33;
        s->shepard[i] = mark + 0.34;
        if (i >= first_wall)
            for (int a = 0; a < 2; a++) s->p_wall[a][i - first_wall] = mark + 0.4 * (a + 1);
    }
    assert_int_equal(cloud_build(cloud), MNS_OK);
    size_t moved = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double mark = s->id[i];
        moved += i > 0 && s->id[i] < s->id[i - 1];
        for (int d = 0; d < 3; d++) {
            assert_true(s->ref[d][i] == s->x[d][i]);
            assert_true(s->v[d][i] == mark + 0.1 * (d + 1));
            assert_true(s->a[d][i] == mark + 0.2 * (d + 1));
            assert_true(s->b[d][i] == mark + 0.01 * (d + 1));
        }
        assert_true(s->m[i] == mark + 0.31 && s->rho[i] == mark + 0.32 && s->p[i] == mark + 0.33);
        assert_true(s->shepard[i] == mark + 0.34);
        assert_int_equal(s->phase[i], group_of(s, i));
        if (i >= first_wall)
            for (int a = 0; a < 2; a++) assert_true(s->p_wall[a][i - first_wall] == mark + 0.4 * (a + 1));
    }
    assert_true(moved > s->n / 10);
    assert_complete(cloud);
    cloud_free(cloud);
}

static void more_neighbours_than_a_row_holds_are_refused(void **state)
{
    (void)state;
    static const struct {
        size_t n[2];
        MnsStatus status;
    } rows[] = {{{25, 41}, MNS_OK}, {{27, 38}, MNS_E_LIMIT}}; /* 1025 and 1026 particles: 1024 and 1025 neighbours */
    assert_int_equal(ROW_MAX, 1024);
    for (size_t k = 0; k < 2; k++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = 0.1, .n = {rows[k].n[0], rows[k].n[1]}});
        for (size_t i = 0; i < cloud->s.n; i++)
            for (int d = 0; d < 2; d++) cloud->s.x[d][i] *= 0.01;
        assert_int_equal(cloud_build(cloud), rows[k].status);
        cloud_free(cloud);
    }
}

static void a_position_that_is_no_number_does_no_harm(void **state)
{
    (void)state;
    for (int periodic = 0; periodic < 2; periodic++) {
        Cloud *cloud =
            cloud_new(&(CloudSetup){.dim = 2, .dx = 0.1, .n = {12, 9}, .periodic = {periodic, periodic}, .skin = 0.3});
        cloud->s.x[0][17] = NAN;
        cloud->s.x[1][40] = INFINITY;
        cloud->s.x[0][60] = -1e300;
        assert_int_equal(cloud_build(cloud), MNS_OK);
        for (size_t i = 0; i < cloud->s.n; i++)
            if (!isfinite(cloud->s.x[0][i] + cloud->s.x[1][i])) assert_int_equal(cloud->nb.end[i][END_WALLS], 0);
        cloud_free(cloud);
    }
}

/* What has left an open domain is spread over the cells: with all of it in the outermost ones, a step would cost the square of
 * their number. */
static void particles_that_have_left_are_spread_over_the_cells(void **state)
{
    (void)state;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = 0.02, .n = {50, 50}, .skin = 0.3, .threads = 2});
    uint64_t seed = 3;
    const size_t n = cloud->s.n;
    for (size_t i = 0; i < n; i++) {
        const double fall = i % 5 == 0 ? 1e14 : 60; /* some fell very long ago */
        cloud->s.x[0][i] += 4 * cloud_noise(&seed);
        cloud->s.x[1][i] -= fall * (1 + cloud_noise(&seed));
        for (int d = 0; d < 2; d++) cloud->s.ref[d][i] = cloud->s.x[d][i];
    }
    assert_int_equal(cloud_build(cloud), MNS_OK);
    size_t most = 0;
    for (size_t k = 0; k < cloud->nb.grid.cells; k++) {
        const size_t held = cloud->nb.start[k + 1] - cloud->nb.start[k];
        most = held > most ? held : most;
    }
    assert_true(cloud->nb.grid.cells > 200);
    assert_less((double)most, 0.02 * (double)n);
    assert_complete(cloud);
    cloud_free(cloud);
}

/* However long a domain is, its cells are no wider than elsewhere, so that as few particles out of reach are looked at. */
static void cells_of_a_long_domain_are_as_wide_as_the_reach(void **state)
{
    (void)state;
    for (int along = 0; along < 2; along++)
        for (int periodic = 0; periodic < 2; periodic++) {
            CloudSetup setup = {.dim = 2, .dx = 0.1, .n = {3, 3, 1}, .skin = 0.3, .owner = NULL};
            setup.n[along] = 6000;
            setup.periodic[along] = periodic;
            Cloud *cloud = cloud_new(&setup);
            const double reach = cloud->model.kernel.support + cloud->model.skin;
            assert_int_equal(cloud->nb.grid.n[along], (int)floor(600 / reach));
            assert_less(cloud->nb.grid.ratio, 1 + 1e-12);
            assert_mutual(cloud);
            assert_complete_of(cloud, 37); /* of 18,000, whose pairs are many */
            cloud_free(cloud);
        }
}

/* Nor does it matter how wide a domain is that is almost empty. */
static void cells_of_an_endless_domain_can_be_counted(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int periodic = 0; periodic < 2; periodic++) {
            Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {6, 5, 4}, .owner = NULL});
            for (int d = 0; d < dim; d++) {
                cloud->model.max[d] = 1e15;
                cloud->model.period[d] = periodic ? 1e15 : 0;
            }
            const Grid grid = grid_make(&cloud->s, &cloud->model, 0.3, 1);
            assert_in_range(grid.cells, 1000, 4096 + 8 * cloud->s.n);
            assert_true(grid.cells <= grid_cells_most(&cloud->model, 0.3, cloud->s.n));
            for (size_t i = 0; i < cloud->s.n; i++) {
                const double x[3] = {cloud->s.x[0][i], cloud->s.x[1][i], dim == 3 ? cloud->s.x[2][i] : 0};
                assert_true(grid_cell(&grid, x) < grid.cells);
            }
            cloud_free(cloud);
        }
}

/* Water in one corner of a wide box, and a speck far off. */
static int corner(const double x[3])
{
    const bool speck = x[0] > 9.5 && x[1] > 9.5 && x[2] > 9.5;
    return speck || (x[0] < 1.1 && x[1] < 1.3 && x[2] < 0.9) ? CLOUD_WATER : CLOUD_NOTHING;
}

static void cells_are_as_many_as_the_particles_need(void **state)
{
    (void)state;
    for (int periodic = 0; periodic < 8; periodic++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 3,
                                               .dx = 0.1,
                                               .n = {100, 100, 100},
                                               .periodic = {periodic & 1, periodic & 2, periodic & 4},
                                               .skin = 0.3,
                                               .owner = corner});
        assert_in_range(cloud->s.n, 1000, 2000);
        assert_in_range(cloud->nb.grid.cells, 4096, 4096 + 8 * cloud->s.n);
        assert_complete(cloud);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_are_complete_in_two_dimensions_periodic_or_not),
        cmocka_unit_test(lists_are_complete_in_three_dimensions_periodic_or_not),
        cmocka_unit_test(lists_go_on_from_column_to_column),
        cmocka_unit_test(runs_go_round_over_a_narrow_last_column),
        cmocka_unit_test(particles_outside_the_domain_have_neighbours_too),
        cmocka_unit_test(a_wide_kernel_and_a_wide_skin_are_no_problem),
        cmocka_unit_test(a_domain_smaller_than_the_reach_is_searched_whole),
        cmocka_unit_test(lone_fluids_need_no_other_group),
        cmocka_unit_test(lists_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(building_again_from_the_same_positions_changes_nothing),
        cmocka_unit_test(particles_keep_their_own_values_when_sorted),
        cmocka_unit_test(more_neighbours_than_a_row_holds_are_refused),
        cmocka_unit_test(a_position_that_is_no_number_does_no_harm),
        cmocka_unit_test(particles_that_have_left_are_spread_over_the_cells),
        cmocka_unit_test(cells_are_as_many_as_the_particles_need),
        cmocka_unit_test(cells_of_a_long_domain_are_as_wide_as_the_reach),
        cmocka_unit_test(cells_of_an_endless_domain_can_be_counted),
    };
    return cmocka_run_group_tests_name("neighbours", tests, NULL, NULL);
}
