/* SPDX-License-Identifier: BSD-3-Clause */
/* A wall across the seam of a periodic domain is whole: the flow around it is that around the same wall in the middle. And a
 * particle that the guard keeps from two walls at once is one particle. */
#include "tests/support/check.h"
#include "tests/support/sims.h"

/* Water blown through rows of posts; one stands at x = middle, which moves up and down across the other seam. */
static MnsCase *posts(int dim, double middle)
{
    MnsCase *c = case_blank(dim, 16);
    for (int d = 0; d < dim; d++) c->periodic[d] = true;
    case_add_fluid(c, "water", 1, 10);
    case_set_text(&c->fluids[0].velocity[0], "1");
    case_set_text(&c->fluids[0].velocity[1], "0.3*sin(2*pi*y)");
    case_set_text(&c->gravity[0], "2");
    case_add_wall(c, "post");
    MnsPart *part = case_add_part(&c->walls[0].shape, dim == 2 ? MNS_BALL : MNS_CYLINDER);
    part->a[0] = part->b[0] = middle;
    part->a[1] = part->b[1] = 0.96875;
    part->b[2] = 1; /* without ends */
    part->radius = 0.21;
    c->walls[0].motion = (MnsMotion){.kind = MNS_ONE_MINUS_COSINE, .amplitude = {0, 0.05, 0}, .frequency = 1};
    return c;
}

/* The fluid particle nearest to the middle of the post, over images. */
static double nearest(const MnsSim *sim, double middle)
{
    double least = INFINITY;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const double x = model_nearest(&sim->model, 0, sim->s.x[0][i] - middle),
                     y = model_nearest(&sim->model, 1, sim->s.x[1][i] - 0.96875 - sim->model.wall[0].x[1]);
        least = fmin(least, sqrt(x * x + y * y));
    }
    return least;
}

static double kinetic(const MnsSim *sim)
{
    double sum = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++)
        for (int d = 0; d < sim->s.dim; d++) sum += sim->s.m[i] * sim->s.v[d][i] * sim->s.v[d][i];
    return sum;
}

/* The middle of a cell, so that half a period further is one too. The sums of rows are done in another order, which is all
 * that may differ. */
static void flow_past_a_post_on_the_seam_is_that_past_one_in_the_middle(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double places[2] = {0.53125, 0.03125};
        double energy[2];
        size_t walls[2], guarded[2];
        for (int k = 0; k < 2; k++) {
            MnsCase *c = posts(dim, places[k]);
            MnsSim *sim = sim_in_arrays(c);
            walls[k] = sim->s.n - particles_fluid(&sim->s);
            for (int step = 0; step < 150; step++) {
                assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_OK);
                assert_less(0.21, nearest(sim, places[k]));
            }
            energy[k] = kinetic(sim);
            guarded[k] = mns_sim_progress(sim).guarded;
            sim_done(sim, c);
        }
        assert_int_equal(walls[0], walls[1]);
        assert_int_equal(guarded[0], guarded[1]);
        assert_close(energy[0], energy[1], 1e-9 * energy[0]);
    }
}

/* As much of a drop on the seam is there as of one in the middle. */
static void fluid_across_a_seam_is_whole_too(void **state)
{
    (void)state;
    size_t counts[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_periodic(3, 16);
        *c->fluids[0].shape.parts = (MnsPart){.primitive = MNS_BALL,
                                              .a = {k ? 0.03125 : 0.53125, 0.96875, 0.53125},
                                              .radius = 0.31,
                                              .formula = c->fluids[0].shape.parts->formula};
        MnsSim *sim = sim_in_arrays(c);
        for (size_t i = 0; i < sim->s.n; i++) counts[k] += sim->s.phase[i] == 0;
        sim_done(sim, c);
    }
    assert_int_equal(counts[0], counts[1]);
    assert_true(counts[0] > 400);
}

/* Two walls share a corner; a particle put into it is kept from both. */
static void particle_between_two_walls_is_kept_once(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 10);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
    case_add_wall(c, "step");
    MnsPart *step = case_add_part(&c->walls[1].shape, MNS_BOX);
    step->a[0] = 3;
    step->b[0] = 4;
    step->b[1] = 1;
    MnsSim *sim = sim_in_arrays(c);
    sim->s.x[0][0] = 2.99;
    sim->s.x[1][0] = 0.01;
    for (size_t i = 1; i < particles_fluid(&sim->s); i++) sim->s.x[1][i] = 1.5; /* far from all walls */
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {                     /* and none is passed over */
        sim->nb.end[i][END_FLUID] = 0;
        sim->nb.end[i][END_WALLS] = 1;
    }
    assert_int_equal(guard_walls(sim), 1);
    assert_close(sim->s.x[0][0], 3 - 0.025, 1e-12);
    assert_close(sim->s.x[1][0], 0.025, 1e-12);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flow_past_a_post_on_the_seam_is_that_past_one_in_the_middle),
        cmocka_unit_test(fluid_across_a_seam_is_whole_too),
        cmocka_unit_test(particle_between_two_walls_is_kept_once),
    };
    return cmocka_run_group_tests_name("wall_seam", tests, NULL, NULL);
}
