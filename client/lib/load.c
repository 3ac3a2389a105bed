/* SPDX-License-Identifier: BSD-3-Clause */
/* Loading a case from a file: complaints of the daemon point to line and column of the file, as complaints about the
 * text do. */
#include "common/case/load.h"
#include "client/lib/commands.h"
#include "common/case/name.h"
#include "common/case/value.h"
#include <string.h>

/* The name, conditions and a lease come with the request, and are no fault of the file. */
static bool is_of_case(const char *path)
{
    return case_field_named(&meniscus__case__descriptor, path, strcspn(path, ".[")) != NULL;
}

static MnsStatus send_case(MnsClient *client, Meniscus__Request request, const MnsLoad *from, const CaseFile *file,
                           MnsReply **ret_reply, MnsError *error)
{
    char name[CASE_NAME_SIZE];
    case_name_from_path(from->file, name);
    Meniscus__Load load;
    MnsStatus status = load_init(&load, file, error);
    if (status != MNS_OK) return status;
    load.name = from->name ? (char *)from->name : name;
    load.has_resume = true;
    load.resume = from->resume;
    request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    request.load = &load;
    MnsError why = {0};
    status = command_call(client, &request, ret_reply, &why);
    load_done(&load);
    if (status != MNS_OK && is_of_case(why.path)) case_file_locate(file, &why);
    if (status != MNS_OK && error) *error = why;
    return status;
}

MnsStatus mns_client_load(MnsClient *client, const MnsLoad *load, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    CaseFile *file = NULL;
    MnsStatus status = case_file_read_with(load->file, load->n_sets, load->sets, &file, error);
    if (status == MNS_OK) status = send_case(client, request, load, file, ret_reply, error);
    case_file_free(file);
    return status;
}
