/* SPDX-License-Identifier: BSD-3-Clause */
/* What is seen at points beside a mirror is what is seen there in the whole of which it cuts half off: fields, and shares of fluids as if they went on behind
 * it. But a gap beside it is as wide as it is. */
#include "sim/sample.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"

/* A tank 2 wide and 1 high, closed by walls that let fluid glide, or its right half. Water to the left of a slope and air on its right, alike on both sides. */
static MnsCase *tank(bool half, const char *scheme)
{
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = scheme;
    c->min[0] = half ? 0 : -1;
    case_add_fluid(c, "water", 1000, 20);
    case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "abs(x) < 0.2 + 0.5*y");
    case_add_fluid(c, "air", 500, 20);
    for (size_t k = 0; k < 2; k++) {
        case_set_text(&c->fluids[k].velocity[0], "x*(1 + y)");
        case_set_text(&c->fluids[k].velocity[1], "cos(2*x) + y");
        case_set_text(&c->fluids[k].pressure, "100*cos(3*x) + 50*y");
    }
    case_add_wall(c, "tank");
    MnsPart *outside = case_add_part(&c->walls[0].shape, MNS_BOX);
    outside->outside = true;
    for (int d = 0; d < 2; d++) {
        outside->a[d] = c->min[d];
        outside->b[d] = c->max[d];
    }
    return c;
}

static void points_beside_a_mirror_see_the_whole(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences", "riemann", "dissipation", "interfacial"};
    static const double points[][3] = {{0.01, 0.4}, {0.05, 0.1}, {0.1, 0.55}, {0.2, 0.31}, {0.3, 0.2}, {0.02, 0.97}};
    enum { POINTS = sizeof points / sizeof *points };
    for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
        MnsCase *of_whole = tank(false, schemes[k]), *of_part = tank(true, schemes[k]);
        MnsSim *whole = sim_of(of_whole), *part = sim_of(of_part);
        for (int of = 0; of < 4; of++) {
            const int field = mns_field_find(of == 0 ? "pressure" : of == 1 ? "density" : "velocity");
            double seen[POINTS], due[POINTS];
            mns_sim_sample(whole, field, of < 3 ? 0 : 1, POINTS, points, due);
            mns_sim_sample(part, field, of < 3 ? 0 : 1, POINTS, points, seen);
            for (int p = 0; p < POINTS; p++) assert_close(seen[p], due[p], 1e-9 * (1 + fabs(due[p])));
        }
        for (int p = 0; p < POINTS; p++) {
            const double behind[3] = {-points[p][0], points[p][1], 0};
            const Share due = sample_share(whole, points[p], 1), seen = sample_share(part, points[p], 1),
                        beyond = sample_share(part, behind, 1);
            assert_close(seen.fluid, due.fluid, 1e-9);
            if (points[p][0] > 0.15) continue; /* it goes on for a kernel's width, as far as walls have particles */
            assert_close(beyond.fluid, due.fluid, 1e-9);
            assert_true(beyond.open < 0.5 && beyond.open < seen.open);
        }
        mns_sim_free(whole);
        mns_sim_free(part);
        mns_case_free(of_whole);
        mns_case_free(of_part);
    }
}

/* The lattice goes on in the walls, and there is no fluid above the middle of the left part: beside the mirror it is covered by half. */
static void a_gap_beside_a_mirror_is_not_seen_twice(void **state)
{
    (void)state;
    MnsCase *c = tank(true, "riemann");
    case_set_text(&c->fluids[0].shape.parts[0].formula, "x > 0.25 and x < 0.9");
    case_set_text(&case_add_part(&c->fluids[1].shape, MNS_FORMULA)->formula, "x >= 0.9");
    MnsSim *sim = sim_of(c);
    const double beside[3] = {1e-9, 0.5, 0}, within[3] = {0.6, 0.5, 0}, in_gap[3] = {0.125, 0.5, 0};
    assert_close(sample_cover(sim, within), 1, 0.02);
    assert_close(sample_cover(sim, beside), 0.5, 0.02);
    assert_less(sample_cover(sim, in_gap), 0.2);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_beside_a_mirror_see_the_whole),
        cmocka_unit_test(a_gap_beside_a_mirror_is_not_seen_twice),
    };
    return cmocka_run_group_tests_name("sample", tests, NULL, NULL);
}
