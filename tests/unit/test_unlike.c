/* SPDX-License-Identifier: BSD-3-Clause */
/* How pairs of unlike fluids are averaged and kept apart is warned of where it does not suit their surface tension. */
#include "cases/translate.h"
#include "tests/support/check.h"
#include "tests/support/shipped.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <string.h>

static void average(MnsCase *c, MnsPairAverage how)
{
    c->scheme.dissipation.pair_average = c->scheme.interfacial.pair_average = how;
}

static void repel(MnsCase *c, double repulsion)
{
    c->scheme.dissipation.repulsion = c->scheme.interfacial.repulsion = repulsion;
}

/* Two stripes of densities 1 and 0.1 at rest. */
static MnsCase *case_tense(const char *scheme, double tension)
{
    MnsCase *c = case_still(2, 10, MNS_DENSITY_AUTOMATIC);
    c->scheme.name = scheme;
    c->tension[0][1] = c->tension[1][0] = tension;
    c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
    average(c, MNS_AVERAGE_DENSITY);
    repel(c, 0);
    return c;
}

static bool case_warns(MnsCase *c, const char *words)
{
    MnsSim *sim = sim_of(c);
    const bool said = sim_warns(sim, words);
    sim_done(sim, c);
    return said;
}

static void repulsion_beside_tension_is_warned_of(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial"};
    for (int k = 0; k < 2; k++) {
        for (int other = 0; other < 3; other++) {
            MnsCase *c = case_tense(schemes[k], other == 1 ? 0 : 0.01);
            char words[256];
            repel(c, other == 2 ? 0 : 0.04);
            snprintf(words, sizeof words, "scheme.%s.repulsion: 0.04 pushes unlike fluids apart", schemes[k]);
            assert_int_equal(case_warns(c, words), other == 0);
        }
        MnsCase *c = case_tense(schemes[k], 0.01);
        repel(c, 0.04);
        assert_true(case_warns(c, "and takes about 4 % of the pressure jump of a drop at rest, and more without"));
    }
}

static void arithmetic_averages_beside_tension_are_warned_of(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial", "incompressible", "differences"};
    for (int k = 0; k < 4; k++)
        for (int other = 0; other < 4; other++) {
            MnsCase *c = case_tense(schemes[k], other == 1 ? 0 : 0.01);
            char words[256];
            if (other != 2) average(c, MNS_AVERAGE_ARITHMETIC);
            if (other == 3) c->fluids[1].density = c->fluids[0].density;
            snprintf(words, sizeof words, "scheme.%s.pair_average: arithmetic averages make", schemes[k]);
            assert_int_equal(case_warns(c, words), other == 0 && k < 2);
        }
    MnsCase *c = case_tense("interfacial", 0.01);
    average(c, MNS_AVERAGE_ARITHMETIC);
    assert_true(case_warns(c, "by 13 % at a ratio of densities of 10 (10 here); take density"));
}

/* The gas of `dissipation` comes before the bubble that is too fast; `interfacial` holds it. */
static void arithmetic_averages_beside_a_gas_are_said_to_burst_it(void **state)
{
    (void)state;
    static const struct {
        const char *scheme, *words;
    } rows[] = {{"dissipation", "averages burst a gas above 200"}, {"interfacial", "too fast, by 13 % at a ratio"}};
    for (int k = 0; k < 2; k++)
        for (int tense = 0; tense < 2; tense++) {
            MnsCase *c = case_tense(rows[k].scheme, tense ? 0.001 : 0);
            average(c, MNS_AVERAGE_ARITHMETIC);
            c->fluids[1].density = c->fluids[0].density / 500;
            assert_int_equal(case_warns(c, rows[k].words), k == 0 || tense);
        }
}

static void both_are_told_when_a_run_is_steered_to_them(void **state)
{
    (void)state;
    MnsCase *c = case_tense("interfacial", 0.01), *other = case_tense("interfacial", 0.01);
    MnsSim *sim = sim_of(c);
    repel(other, 0.08);
    average(other, MNS_AVERAGE_ARITHMETIC);
    assert_false(sim_warns(sim, "repulsion") || sim_warns(sim, "pair_average"));
    assert_int_equal(mns_sim_steer(sim, other, NULL), MNS_OK);
    assert_true(sim_warns(sim, "scheme.interfacial.repulsion: 0.08 ") &&
                sim_warns(sim, "scheme.interfacial.pair_average: "));
    mns_case_free(c);
    sim_done(sim, other);
}

/* No scheme with tension reads how a density is found, so that no liquid's is summed there without a word. */
static void a_way_of_densities_beside_tension_is_said_to_be_of_no_use(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial", "incompressible", "differences"};
    for (int k = 0; k < 4; k++)
        for (int given = 0; given < 2; given++) {
            MnsCase *c = case_tense(schemes[k], 0.01);
            if (given) c->fluids[0].density_method = MNS_DENSITY_SUMMATION;
            char words[256];
            snprintf(words, sizeof words, "fluids[0].density_method: the scheme %s makes no use of it; leave it out",
                     schemes[k]);
            assert_int_equal(case_warns(c, words), given);
        }
}

/* Four fluids that mind each other alike have one share each; two of them that do not mind each other have another beside the third and the fourth. */
static void lines_that_ask_for_unlike_shares_are_warned_of(void **state)
{
    (void)state;
    for (int unlike = 0; unlike < 2; unlike++) {
        MnsCase *c = case_tense("interfacial", 0.01);
        case_add_fluid(c, "oil", 1, 20);
        case_add_fluid(c, "wax", 1, 20);
        for (size_t k = 2; k < 4; k++) {
            const double at[3] = {0.25 * (double)k, 0.25, 0};
            MnsPart *ball = case_add_part(&c->fluids[k].shape, MNS_BALL);
            memcpy(ball->a, at, sizeof at);
            ball->radius = 0.11;
        }
        for (int a = 0; a < 4; a++)
            for (int b = 0; b < 4; b++) c->tension[a][b] = a == b ? 0 : 0.01;
        if (unlike) c->tension[2][3] = c->tension[3][2] = 0;
        assert_int_equal(case_warns(c, "lines where three of them meet are drawn aside"), unlike);
    }
}

/* Up to 10 it was measured to hold; without tension any ratio does. */
static void tension_between_unlike_densities_is_warned_of_under_differences(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial", "incompressible", "differences"};
    static const double ratios[] = {1, 10, 12, 1000};
    for (int k = 0; k < 4; k++)
        for (int q = 0; q < 8; q++) {
            MnsCase *c = case_tense(schemes[k], q < 4 ? 0.001 : 0);
            c->fluids[1].density = c->fluids[0].density / ratios[q % 4];
            char words[160];
            snprintf(words, sizeof words,
                     "interfaces: fluids with surface tension differ in density by a factor of %g, and the scheme "
                     "differences is known to hold it up to 10: ",
                     ratios[q % 4]);
            assert_int_equal(case_warns(c, words), k == 3 && (q == 2 || q == 3));
        }
}

/* Coarse in space, as some have a hundred thousand particles. */
static void assert_obeys(CaseFile *file)
{
    static const char *const rules[] = {
        ".repulsion: ",       ".pair_average: ", ".background_pressure: ", ".density_method: ", "scheme.kernel: ",
        "scheme.smoothing: ", "interfaces: "};
    MnsCase *c;
    assert_int_equal(case_translate(case_file_message(file), &c, NULL), MNS_OK);
    if (c->dim == 3) c->resolution /= 2;
    MnsSim *sim = sim_of(c);
    for (size_t k = 0; k < sizeof rules / sizeof *rules; k++)
        if (sim_warns(sim, rules[k])) fail_msg("%s: warned of %s", c->title, rules[k]);
    sim_done(sim, c);
}

static void shipped_cases_obey_the_rules(void **state)
{
    (void)state;
    assert_true(shipped_each(assert_obeys) > 30);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(repulsion_beside_tension_is_warned_of),
        cmocka_unit_test(arithmetic_averages_beside_tension_are_warned_of),
        cmocka_unit_test(arithmetic_averages_beside_a_gas_are_said_to_burst_it),
        cmocka_unit_test(both_are_told_when_a_run_is_steered_to_them),
        cmocka_unit_test(a_way_of_densities_beside_tension_is_said_to_be_of_no_use),
        cmocka_unit_test(lines_that_ask_for_unlike_shares_are_warned_of),
        cmocka_unit_test(tension_between_unlike_densities_is_warned_of_under_differences),
        cmocka_unit_test(shipped_cases_obey_the_rules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
