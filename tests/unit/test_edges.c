/* SPDX-License-Identifier: BSD-3-Clause */
/* A fluid whose edges are off the lattice has more or less of it than its shape holds, and where that is more than 1 % it is said: how much, and
 * of which fluid. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <string.h>

/* A tank of 2 x 1 (x 1) m with spacings of 1/20 (1/10) m, and water in it that has no shape as yet. */
static MnsCase *tank(int dim)
{
    MnsCase *c = case_blank(dim, dim == 2 ? 20 : 10);
    c->max[0] = 2;
    case_add_fluid(c, "water", 1000, 20);
    case_add_wall(c, "tank");
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < 3; d++) box->b[d] = c->max[d];
    return c;
}

static void add_box(MnsShape *shape, double low, double high)
{
    MnsPart *box = case_add_part(shape, MNS_BOX);
    for (int d = 0; d < 3; d++) box->b[d] = 2;
    box->a[1] = low;
    box->b[1] = high;
}
static void box(MnsCase *c, double depth)
{
    add_box(&c->fluids[0].shape, 0, depth);
}
static void half_space(MnsCase *c, double depth)
{
    MnsPart *plane = case_add_part(&c->fluids[0].shape, MNS_HALF_SPACE);
    plane->a[1] = depth;
    plane->b[1] = 1;
}
static void formula(MnsCase *c, double depth)
{
    char text[64];
    snprintf(text, sizeof text, "y < %.17g", depth);
    case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, text);
}
static void block_above(MnsCase *c, double depth) /* a wall with its lower side off the lattice, and water all below */
{
    case_add_wall(c, "block");
    add_box(&c->walls[1].shape, depth, 2);
}

/* Per cent of water more than its shape holds, as is said; 0: nothing is. */
static double said(const MnsCase *c, const char *fluid)
{
    MnsSim *sim = sim_of(c);
    double percent = 0;
    const char *text;
    for (size_t k = 0; (text = mns_sim_warning(sim, k)); k++) {
        char name[32], word[8];
        const char *from = strchr(text, ':');
        if (!strstr(text, "mass than its shape holds")) fail_msg("%s", text);
        if (sscanf(from, ": %31s starts with %lf %% %7s", name, &percent, word) != 3) fail_msg("%s", text);
        if (strcmp(name, fluid) != 0) percent = 0;
        else if (strcmp(word, "less") == 0) percent = -percent;
        if (percent != 0) break;
    }
    mns_sim_free(sim);
    return percent;
}

static void mass_off_by_more_than_a_hundredth_is_said(void **state)
{
    (void)state;
    static void (*const shapes[])(MnsCase * c, double depth) = {box, half_space, formula, block_above};
    static const double cells[] = {9.48, 9.5001, 9.97, 10, 10.03, 10.4, 8.2};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++)
            for (size_t q = 0; q < sizeof cells / sizeof *cells; q++) {
                MnsCase *c = tank(dim);
                const double off = 100 * (round(cells[q]) / cells[q] - 1), n = dim == 3 ? cells[q] - 5 : cells[q];
                const double right = dim == 3 ? 100 * (round(n) / n - 1) : off;
                shapes[k](c, n / c->resolution);
                const double found = said(c, "water");
                if (!(fabs(found - (fabs(right) > 1 ? right : 0)) < 0.16)) /* a half of 1/64, of 5 cells; and digits */
                    fail_msg("%d, shape %zu, %g cells: %g %% said of %g", dim, k, cells[q], found, right);
                mns_case_free(c);
            }
}

static void fluid_that_takes_the_rest_is_named_too(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    case_add_fluid(c, "air", 1, 20);
    box(c, 0.474);
    assert_close(said(c, "water"), 100 * (9 / 9.48 - 1), 0.15);
    assert_close(said(c, "air"), 100 * (11 / 10.52 - 1), 0.15);
    c->max[1] = c->walls[0].shape.parts[0].b[1] = 4; /* with 0.48 cells more of 70 it is less than 1 % of the air */
    assert_true(said(c, "air") == 0);
    mns_case_free(c);
}

/* Of a ball, by the formula of its area or volume. */
static void drops_have_what_their_shapes_hold(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int told = 0; told < 2; told++) {
            MnsCase *c = tank(dim);
            MnsPart *ball = case_add_part(&c->fluids[0].shape, told ? MNS_FORMULA : MNS_BALL);
            const double R = dim == 2 ? 0.1 : 0.23;
            ball->radius = R;
            ball->a[0] = 1;
            ball->a[1] = 0.5;
            ball->a[2] = dim == 3 ? 0.5 : 0;
            case_set_text(&ball->formula, dim == 2 ? "(x - 1)^2 + (y - 0.5)^2 < 0.01"
                                                   : "(x - 1)^2 + (y - 0.5)^2 + (z - 0.5)^2 < 0.0529");
            MnsSim *sim = sim_of(c);
            const double n = (double)particles_fluid(&sim->s) * sim->model.cell_volume;
            const double held = dim == 2 ? M_PI * R * R : 4 * M_PI / 3 * R * R * R, off = 100 * (n / held - 1);
            mns_sim_free(sim);
            assert_true(fabs(off) > 2); /* or this shows nothing */
            assert_close(said(c, "water"), off, 0.3);
            mns_case_free(c);
        }
}

/* A film between two rows of the lattice has no particle, and the pool below it hides that. */
static void film_without_particles_is_missed(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    box(c, 0.5);
    add_box(&c->fluids[0].shape, 0.785, 0.805);
    assert_close(said(c, "water"), 100 * (10 / 10.4 - 1), 0.2);
    mns_case_free(c);
}

static void periodic_sides_are_no_edges(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int told = 0; told < 2; told++) {
            MnsCase *c = case_periodic(dim, 10);
            c->fluids[0].shape.parts[0].b[0] = 0.5;
            if (told) {
                c->fluids[0].shape.parts[0].primitive = MNS_FORMULA;
                case_set_text(&c->fluids[0].shape.parts[0].formula, "x < 0.5");
            }
            MnsSim *sim = sim_of(c);
            if (mns_sim_warning(sim, 0)) fail_msg("%d, %d: %s", dim, told, mns_sim_warning(sim, 0));
            sim_done(sim, c);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mass_off_by_more_than_a_hundredth_is_said),
        cmocka_unit_test(fluid_that_takes_the_rest_is_named_too),
        cmocka_unit_test(drops_have_what_their_shapes_hold),
        cmocka_unit_test(film_without_particles_is_missed),
        cmocka_unit_test(periodic_sides_are_no_edges),
    };
    return cmocka_run_group_tests_name("edges", tests, NULL, NULL);
}
