/* SPDX-License-Identifier: BSD-3-Clause */
/* The hash of the state that a case is in after some steps, without a run directory, probes or files: what tells whether a change of the
 * program has changed a flow.
 *
 * usage: state_after CASE STEPS [PATH=VALUE ...] */
#include "cases/translate.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "sim/sim.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static MnsStatus read_case(int argc, char **argv, MnsCase **ret, MnsError *error)
{
    char path[4096];
    CaseFile *file = NULL;
    MnsStatus status = case_find(argv[1], path, error);
    if (!status) status = case_file_read(path, &file, error);
    for (int k = 3; k < argc && !status; k++) status = case_file_set(file, argv[k], error);
    if (!status) status = case_translate(case_file_message(file), ret, error);
    case_file_free(file);
    return status;
}

/* A flow that ends or diverges before has the state of its last step. */
static MnsStatus go(const MnsCase *c, unsigned long steps, uint64_t *ret_hash, MnsError *error)
{
    MnsSim *sim = NULL;
    const MnsStatus status = mns_sim_new(c, &sim, error);
    if (status) return status;
    MnsError end;
    while (mns_sim_progress(sim).step < steps && mns_sim_progress(sim).t < c->end_time)
        if (mns_sim_step(sim, c->end_time, &end)) break;
    *ret_hash = mns_sim_hash(sim);
    mns_sim_free(sim);
    return MNS_OK;
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: state_after CASE STEPS [PATH=VALUE ...]\n");
        return 64;
    }
    MnsCase *c = NULL;
    MnsError error;
    uint64_t hash = 0;
    MnsStatus status = read_case(argc, argv, &c, &error);
    if (!status) status = go(c, strtoul(argv[2], NULL, 10), &hash, &error);
    mns_case_free(c);
    if (status) {
        fprintf(stderr, "state_after: %s\n", error.text);
        return 65;
    }
    printf("%016" PRIx64 "\n", hash);
    return 0;
}
