/* SPDX-License-Identifier: BSD-3-Clause */
/* A seal in front of an HDF5 file: no damaged byte gets past it. */
#include "io/seal.h"
#include "io/atomic_file.h"

#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

typedef struct Seal {
    char magic[8];
    uint32_t version, zero;
    uint64_t size, hash, number, records, first, last;
    char unused[SEAL_SIZE - 72];
    uint64_t own_hash;
} Seal;

_Static_assert(sizeof(Seal) == SEAL_SIZE, "the seal is a file format");

static const char seal_magic[8] = {'M', 'E', 'N', 'I', 'S', 'C', 'U', 'S'};

static uint64_t own_hash(const Seal *seal)
{
    return htole64(XXH64(seal, offsetof(Seal, own_hash), 0));
}

/* Hash and count what follows the seal. @return 0 or an errno. */
static int hash_rest(int fd, uint64_t *ret_size, uint64_t *ret_hash)
{
    enum { BLOCK = 1 << 20 };
    void *block = malloc(BLOCK);
    XXH64_state_t *state = XXH64_createState();
    int failure = block && state ? 0 : ENOMEM;
    size_t got = BLOCK;
    *ret_size = SEAL_SIZE;
    if (!failure) XXH64_reset(state, 0);
    while (!failure && got == BLOCK) {
        failure = file_read_at(fd, block, BLOCK, *ret_size, &got);
        if (failure) break;
        XXH64_update(state, block, got);
        *ret_size += got;
    }
    if (!failure) *ret_hash = XXH64_digest(state);
    XXH64_freeState(state);
    free(block);
    return failure;
}

MnsStatus seal_write(int fd, const char *path, const SealNote *note, MnsError *error)
{
    Seal seal = {.version = htole32(SEAL_VERSION),
                 .number = htole64(note->number),
                 .records = htole64(note->journal.records),
                 .first = htole64(note->journal.first),
                 .last = htole64(note->journal.last)};
    memcpy(seal.magic, seal_magic, sizeof seal.magic);
    uint64_t size = 0, hash = 0;
    int failure = hash_rest(fd, &size, &hash);
    if (failure) return file_fail(error, failure, "read back", path);
    seal.size = htole64(size);
    seal.hash = htole64(hash);
    seal.own_hash = own_hash(&seal);
    failure = file_write_at(fd, &seal, sizeof seal, 0);
    return failure ? file_fail(error, failure, "write", path) : MNS_OK;
}

static MnsStatus check_itself(const Seal *seal, size_t got, const char *path, MnsError *error)
{
    if (got < sizeof *seal) return mns_fail(error, MNS_E_CORRUPT, "'%s' is damaged: it has only %zu bytes", path, got);
    if (memcmp(seal->magic, seal_magic, sizeof seal->magic) != 0)
        return mns_fail(error, MNS_E_CORRUPT, "'%s' is damaged, or not a file of ours: it has no seal", path);
    if (seal->own_hash != own_hash(seal))
        return mns_fail(error, MNS_E_CORRUPT, "'%s' is damaged: the checksum of its seal does not match", path);
    if (le32toh(seal->version) != SEAL_VERSION)
        return mns_fail(error, MNS_E_VERSION, "'%s' has format %u, but this program reads format %d", path,
                        le32toh(seal->version), SEAL_VERSION);
    return MNS_OK;
}

MnsStatus seal_check(int fd, const char *path, MnsError *error)
{
    Seal seal;
    size_t got = 0;
    uint64_t size = 0, hash = 0;
    int failure = file_read_at(fd, &seal, sizeof seal, 0, &got);
    if (failure) return file_fail(error, failure, "read", path);
    const MnsStatus status = check_itself(&seal, got, path, error);
    if (status) return status;
    failure = hash_rest(fd, &size, &hash);
    if (failure) return file_fail(error, failure, "read", path);
    if (size != le64toh(seal.size))
        return mns_fail(error, MNS_E_CORRUPT, "'%s' is damaged: it has %llu bytes, %llu were written", path,
                        (unsigned long long)size, (unsigned long long)le64toh(seal.size));
    if (hash != le64toh(seal.hash))
        return mns_fail(error, MNS_E_CORRUPT, "'%s' is damaged: its checksum does not match", path);
    return MNS_OK;
}

bool seal_read(const char *path, SealNote *ret)
{
    Seal seal;
    size_t got = 0;
    const int fd = file_open(path, O_RDONLY, 0);
    if (fd < 0) return false;
    const int failure = file_read_at(fd, &seal, sizeof seal, 0, &got);
    close(fd);
    if (failure || check_itself(&seal, got, path, NULL)) return false;
    *ret = (SealNote){.number = le64toh(seal.number),
                      .journal = {le64toh(seal.records), le64toh(seal.first), le64toh(seal.last)},
                      .sum = le64toh(seal.hash)};
    return true;
}
