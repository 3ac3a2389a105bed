/* SPDX-License-Identifier: BSD-3-Clause */
/* Simulations of cases made in C. */
#include "tests/support/sims.h"
#include "sim/home.h"
#include "tests/support/check.h"
#include <string.h>

MnsSim *sim_of(const MnsCase *c)
{
    MnsSim *sim = NULL;
    MnsError error = {0};
    if (mns_sim_new(c, &sim, &error)) fail_msg("%s: %s", error.path, error.text);
    return sim;
}

MnsSim *sim_in_arrays(const MnsCase *c)
{
    MnsSim *sim = sim_of(c);
    assert_true(home_leave(&sim->s, sim->threads));
    return sim;
}

void sim_done(MnsSim *sim, MnsCase *c)
{
    mns_sim_free(sim);
    mns_case_free(c);
}

bool sim_warns(const MnsSim *sim, const char *words)
{
    const char *text;
    for (size_t k = 0; (text = mns_sim_warning(sim, k)); k++)
        if (strstr(text, words)) return true;
    return false;
}

void sim_steps(MnsSim *sim, int n)
{
    MnsError error = {0};
    for (int k = 0; k < n; k++)
        if (mns_sim_step(sim, INFINITY, &error)) fail_msg("%s", error.text);
}
