/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles come in the order of their cells, those of a cell in the order they were in, for any number of threads and of cells. */
#include "sim/sort.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

static int three_kinds(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : x[0] < 0.7 ? CLOUD_WATER : CLOUD_AIR;
}

static int two_kinds(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : CLOUD_WATER;
}

static size_t key_of(const Particles *s, const Grid *grid, size_t i)
{
    const double x[3] = {s->ref[0][i], s->ref[1][i], s->dim == 3 ? s->ref[2][i] : 0};
    const size_t air = s->begin[2] > s->begin[1]; /* a group of nobody is left out */
    const size_t group = i < s->begin[1] ? 0 : i < s->begin[2] ? 1 : 1 + air;
    return group * grid->cells + grid_cell(grid, x);
}

static void assert_sorted(const Cloud *cloud, double distance, int threads)
{
    const Particles *s = &cloud->s;
    const Grid grid = grid_make(s, &cloud->model, distance, 1);
    const size_t keys = (s->begin[2] > s->begin[1] ? 3 : 2) * grid.cells;
    uint32_t *start = calloc(keys + 1, sizeof *start), *counts = calloc(sort_counts(threads), sizeof *counts);
    double *room = malloc(s->n * SORT_BYTES_PER_PARTICLE), *other = malloc(s->n * SORT_BYTES_PER_PARTICLE);
    assert_true(start && counts && room && other);
    const uint32_t *order = sort_by_cell(s, &grid, start, counts, room, other, threads);
    uint8_t *seen = calloc(s->n, 1);
    assert_non_null(seen);
    for (size_t k = 0; k < s->n; k++) {
        assert_in_range(order[k], 0, s->n - 1);
        seen[order[k]]++;
        const size_t key = key_of(s, &grid, order[k]);
        assert_in_range(k, start[key], start[key + 1] - 1);
        if (k + 1 < start[key + 1]) assert_true(order[k] < order[k + 1]);
    }
    for (size_t k = 0; k < s->n; k++) assert_int_equal(seen[k], 1);
    assert_int_equal(start[0], 0);
    assert_int_equal(start[keys], s->n);
    free(seen);
    free(other);
    free(room);
    free(counts);
    free(start);
}

/* From one cell to more than there are buckets. */
static void particles_are_in_the_order_of_cells_and_stay_in_that_of_storage_within_one(void **state)
{
    (void)state;
    static const double distances[] = {9, 0.35, 0.11, 0.026};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof distances / sizeof *distances; k++)
            for (int way = 0; way < 6; way++) {
                const bool air = way % 2;
                Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                       .dx = 0.1,
                                                       .n = {14, 11, 9},
                                                       .jitter = 0.6,
                                                       .periodic = {true, false, false},
                                                       .owner = air ? three_kinds : two_kinds});
                assert_sorted(cloud, distances[k], 1 + way / 2);
                cloud_free(cloud);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(particles_are_in_the_order_of_cells_and_stay_in_that_of_storage_within_one),
    };
    return cmocka_run_group_tests_name("sort", tests, NULL, NULL);
}
