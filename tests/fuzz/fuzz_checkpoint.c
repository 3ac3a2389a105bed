/* SPDX-License-Identifier: BSD-3-Clause */
/* A checkpoint, as a restore reads it. Bytes that begin like one are the file: unless its seal is right, it is refused before HDF5, which may crash on
 * them, sees any. All others are a list of changes to a whole checkpoint, made by HDF5 itself and sealed: what it holds may be anything, and what comes of
 * it is a complaint, or a state that a simulation takes or refuses. */
#include "io/checkpoint.h"
#include "io/h5.h"
#include "io/seal.h"
#include "run/document.h"
#include "tests/fuzz/scratch.h"
#include "tests/support/cases.h"
#include <endian.h>
#include <xxhash.h>

enum { CHANGES = 16 };

static MnsSim *sim;
static uint8_t *whole; /* a checkpoint */
static size_t whole_size;

static uint8_t *bytes_of_file(const char *path, size_t *ret_size)
{
    FILE *file = fopen(path, "rb");
    PROMISE(file && !fseek(file, 0, SEEK_END));
    *ret_size = (size_t)ftell(file);
    uint8_t *bytes = malloc(*ret_size + 1);
    rewind(file);
    PROMISE(bytes && fread(bytes, 1, *ret_size, file) == *ret_size);
    fclose(file);
    return bytes;
}

int LLVMFuzzerInitialize(int *argc, char ***argv);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    static const char blob[] = "no case";
    char path[4096];
    MnsCapture *state = NULL;
    MnsCase *c = case_periodic(2, 8);
    const FileMeta meta = {.c = c, .case_name = "dambreak", .case_text = "title: Dam break\n"};
    c->threads = 1;
    H5set_free_list_limits(-1, -1, -1, -1, -1,
                           -1); /* it takes half a MiB for each file, which costs more than all else */
    scratch_begin("checkpoint");
    PROMISE(!mns_sim_new(c, &sim, NULL) && !mns_sim_step(sim, 1, NULL));
    PROMISE(!mns_sim_capture(sim, mns_sim_state_fields(sim), &state, NULL));
    PROMISE(!checkpoint_write(scratch_home, state, &meta, blob, sizeof blob, 1, path, NULL));
    whole = bytes_of_file(path, &whole_size);
    unlink(path);
    mns_capture_free(state);
    return 0;
}

/* --- who reads it --------------------------------------------------------------------------------------------------------- */

static bool is_sealed(const uint8_t *data, size_t size)
{
    uint64_t words[SEAL_SIZE / 8];
    if (size < SEAL_SIZE) return false;
    memcpy(words, data, SEAL_SIZE);
    return le64toh(words[2]) == size && le64toh(words[3]) == XXH64(data + SEAL_SIZE, size - SEAL_SIZE, 0) &&
           le64toh(words[SEAL_SIZE / 8 - 1]) == XXH64(data, SEAL_SIZE - 8, 0);
}

static void go_on(Checkpoint *read)
{
    MnsError error = {0};
    Document *document = NULL;
    MnsStatus status = document_unpack(read->case_blob, read->case_size, "a", &document, &error);
    PROMISE(!status || *error.text);
    document_leave(document);
    status = mns_sim_restore(sim, read->state, &error);
    PROMISE(!status || *error.text);
    checkpoint_done(read);
}

static MnsStatus read_it(void)
{
    Checkpoint read;
    MnsError error = {0};
    const MnsStatus status = checkpoint_read(scratch_path, &read, &error);
    if (status) PROMISE(error.status == status && strstr(error.text, scratch_path));
    else go_on(&read);
    return status;
}

static void read_bytes(const uint8_t *data, size_t size)
{
    scratch_put(data, size);
    const MnsStatus status = read_it();
    PROMISE(is_sealed(data, size) || status == MNS_E_CORRUPT || status == MNS_E_VERSION);
}

/* --- changes -------------------------------------------------------------------------------------------------------------- */

typedef struct Script {
    const uint8_t *at, *end;
    hid_t file;
} Script;

static unsigned draw(Script *script)
{
    return script->at < script->end ? *script->at++ : 0;
}

static uint64_t draw_word(Script *script)
{
    uint64_t word = 0;
    for (int k = 0; k < 8; k++) word = word << 8 | draw(script);
    return word;
}

/* Small as a rule, or of any size. */
static hsize_t draw_extent(Script *script)
{
    const unsigned kind = draw(script);
    return kind < 224 ? kind % 64 : kind < 240 ? UINT64_C(1) << draw(script) % 64 : draw_word(script);
}

/* Also some that there are not, and no dataset. */
static const char *draw_name(Script *script)
{
    static const char *const others[] = {"/case", "/state", "/meniscus", "/other", "/state/other", "/case/other", "/"};
    static char name[128];
    enum { OTHERS = sizeof others / sizeof *others };
    unsigned k = draw(script), fields = 0;
    while (mns_fields()[fields].name) fields++;
    k %= OTHERS + fields;
    snprintf(name, sizeof name, "/state/%s", k < OTHERS ? "" : mns_fields()[k - OTHERS].name);
    return k < OTHERS ? others[k] : name;
}

static const char *draw_mark(Script *script)
{
    static const char *const marks[] = {"xxh64",   "dim",     "n", "n_fluid", "step",     "rebuilds",
                                        "guarded", "spacing", "t", "dt",      "dt_first", "arithmetic"};
    return marks[draw(script) % (sizeof marks / sizeof *marks)];
}

static hid_t draw_type(Script *script)
{
    const unsigned kind = draw(script) % 12;
    const hid_t plain[] = {H5T_NATIVE_UINT64, H5T_NATIVE_DOUBLE, H5T_NATIVE_UINT8, H5T_NATIVE_UINT32,
                           H5T_STD_I16BE,     H5T_IEEE_F32BE,    H5T_STD_REF_OBJ,  H5T_NATIVE_UINT64};
    if (kind < 8) return H5Tcopy(plain[kind]);
    if (kind == 8) return H5Tarray_create2(H5T_NATIVE_UINT64, 1, (hsize_t[]){1 + draw(script) % 9});
    if (kind == 9) return H5Tvlen_create(H5T_NATIVE_UINT8);
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, kind == 10 ? H5T_VARIABLE : 1 + draw(script) % 255);
    return text;
}

static hid_t draw_space(Script *script, bool small)
{
    hsize_t extent[6];
    const unsigned kind = draw(script) % 9;
    if (kind == 7) return H5Screate(H5S_SCALAR);
    if (kind == 8) return H5Screate(H5S_NULL);
    for (unsigned k = 0; k < 6; k++) extent[k] = k >= kind ? 0 : small ? draw(script) % 4 : draw_extent(script);
    return H5Screate_simple((int)(kind < 6 ? kind : 2), extent, NULL);
}

static void make_set(Script *script)
{
    const char *name = draw_name(script);
    const hid_t type = draw_type(script), space = draw_space(script, false), how = H5Pcreate(H5P_DATASET_CREATE);
    const unsigned layout = draw(script) % 4;
    H5Ldelete(script->file, name, H5P_DEFAULT);
    if (layout == 1) H5Pset_layout(how, H5D_COMPACT);
    if (layout > 1)
        H5Pset_chunk(how, H5Sget_simple_extent_ndims(space), (const hsize_t[]){1 + draw(script), 1, 1, 1, 1, 1});
    if (layout == 3) H5Pset_shuffle(how), H5Pset_fletcher32(how);
    H5Pset_alloc_time(how, H5D_ALLOC_TIME_LATE); /* or what is large would be written here */
    H5Pset_fill_time(how, H5D_FILL_TIME_NEVER);
    const hid_t set = H5Dcreate2(script->file, name, type, space, H5P_DEFAULT, how, H5P_DEFAULT);
    if (set >= 0) H5Dclose(set);
    H5Pclose(how);
    H5Sclose(space);
    H5Tclose(type);
}

static void make_mark(Script *script)
{
    const char *name = draw_name(script), *mark = draw_mark(script);
    const hid_t type = draw_type(script), space = draw_space(script, true),
                thing = H5Oopen(script->file, name, H5P_DEFAULT);
    H5Adelete(thing, mark);
    const hid_t attribute = H5Acreate2(thing, mark, type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute >= 0) H5Aclose(attribute);
    if (thing >= 0) H5Oclose(thing);
    H5Sclose(space);
    H5Tclose(type);
}

static bool is_number(hid_t type)
{
    const H5T_class_t kind = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
    return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

/* A new one each time: HDF5 crashes where one that was never written is written later. */
static void set_mark(hid_t file, const char *name, const char *mark, hid_t type, const void *value)
{
    const hid_t thing = H5Oopen(file, name, H5P_DEFAULT), space = H5Screate(H5S_SCALAR);
    H5Adelete(thing, mark);
    const hid_t attribute = H5Acreate2(thing, mark, type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute >= 0) H5Awrite(attribute, type, value), H5Aclose(attribute);
    if (thing >= 0) H5Oclose(thing);
    H5Sclose(space);
}

static void set_number(Script *script)
{
    const char *name = draw_name(script), *mark = draw_mark(script);
    const uint64_t value = draw_extent(script);
    set_mark(script->file, name, mark, H5T_NATIVE_UINT64, &value);
}

static void set_real(Script *script)
{
    const char *mark = draw_mark(script);
    const uint64_t bits = draw_word(script);
    set_mark(script->file, "/state", mark, H5T_NATIVE_DOUBLE, &bits);
}

static void make_link(Script *script)
{
    char to[64], from[128];
    const unsigned kind = draw(script) % 4;
    snprintf(from, sizeof from, "%s", draw_name(script));
    H5Ldelete(script->file, from, H5P_DEFAULT);
    snprintf(to, sizeof to, "%s", draw_name(script));
    if (kind == 0) H5Lcreate_hard(script->file, to, script->file, from, H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 1) H5Lcreate_soft(to, script->file, from, H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 2) H5Lcreate_external(scratch_path, to, script->file, from, H5P_DEFAULT, H5P_DEFAULT);
    if (kind != 3) return;
    const hid_t group = H5Gcreate2(script->file, from, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (group >= 0) H5Gclose(group);
}

/* Some of the bytes of a dataset. */
static void set_bytes(Script *script)
{
    const hid_t set = H5Dopen2(script->file, draw_name(script), H5P_DEFAULT), type = set < 0 ? -1 : H5Dget_type(set);
    const hid_t space = set < 0 ? -1 : H5Dget_space(set);
    const size_t size = H5Tget_size(type);
    const hssize_t n = H5Sget_simple_extent_npoints(space);
    uint8_t *bytes = is_number(type) && n > 0 && n < 4096 ? calloc((size_t)n, size) : NULL;
    if (bytes && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0) {
        const size_t at = draw_extent(script) % ((size_t)n * size);
        for (size_t k = at; k < at + 8 && k < (size_t)n * size; k++) bytes[k] = (uint8_t)draw(script);
        H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes);
    }
    free(bytes);
    if (space >= 0) H5Sclose(space);
    if (type >= 0) H5Tclose(type);
    if (set >= 0) H5Dclose(set);
}

/* The checksum of what is read as this kind of number, right for what is there now. */
static void seal_set(hid_t file, const char *name, hid_t type, size_t size)
{
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
    hsize_t extent[8] = {0};
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank >= 1 && rank <= 4 && H5Sget_simple_extent_dims(space, extent, NULL) >= 0) {
        const hssize_t n = H5Sget_simple_extent_npoints(space);
        uint8_t *bytes = n > 0 && n < 1 << 16 ? calloc((size_t)n, size) : NULL;
        if (bytes && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0) {
            const size_t rows = strcmp(name, "/case") ? extent[0] : 1, row = (size_t)n / rows * size;
            uint64_t hash = 0;
            for (size_t k = 0; k < rows; k++) hash = XXH64(bytes + k * row, row, hash);
            set_mark(file, name, "xxh64", H5T_NATIVE_UINT64, &hash);
        }
        free(bytes);
    }
    if (space >= 0) H5Sclose(space);
    if (set >= 0) H5Dclose(set);
}

static void seal_scalars(hid_t file)
{
    static const char *const names[] = {"dim",     "n",       "n_fluid", "step", "rebuilds",
                                        "guarded", "spacing", "t",       "dt",   "dt_first"};
    uint64_t values[10] = {0};
    for (int k = 0; k < 10; k++) {
        const hid_t mark = H5Aopen_by_name(file, "/state", names[k], H5P_DEFAULT, H5P_DEFAULT);
        const hid_t space = mark < 0 ? -1 : H5Aget_space(mark);
        if (space >= 0 && H5Sget_simple_extent_npoints(space) == 1)
            H5Aread(mark, k < 6 ? H5T_NATIVE_UINT64 : H5T_NATIVE_DOUBLE, &values[k]);
        if (space >= 0) H5Sclose(space);
        if (mark >= 0) H5Aclose(mark);
    }
    const uint64_t hash = XXH64(values, sizeof values, 0);
    set_mark(file, "/state", "xxh64", H5T_NATIVE_UINT64, &hash);
}

static void seal_all(hid_t file)
{
    char name[128];
    seal_scalars(file);
    seal_set(file, "/case", H5T_NATIVE_UINT8, 1);
    for (int k = 0; mns_fields()[k].name; k++) {
        snprintf(name, sizeof name, "/state/%s", mns_fields()[k].name);
        seal_set(file, name, h5_type(mns_fields()[k].type), h5_size(mns_fields()[k].type));
    }
}

static void change(Script *script)
{
    switch (draw(script) % 8) {
    case 0: H5Ldelete(script->file, draw_name(script), H5P_DEFAULT); break;
    case 1: {
        const char *name = draw_name(script);
        H5Adelete_by_name(script->file, name, draw_mark(script), H5P_DEFAULT);
        break;
    }
    case 2: make_set(script); break;
    case 3: make_mark(script); break;
    case 4: set_number(script); break;
    case 5: set_real(script); break;
    case 6: make_link(script); break;
    default: set_bytes(script); break;
    }
}

/* The first byte: whether the checksums within are made right. */
static void read_changed(const uint8_t *data, size_t size)
{
    Script script = {.at = data, .end = data + size};
    const bool seals = draw(&script) % 8 != 0;
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    scratch_put(whole, whole_size);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    script.file = H5Fopen(scratch_path, H5F_ACC_RDWR, access);
    PROMISE(script.file >= 0);
    for (int k = 0; k < CHANGES && script.at < script.end; k++) change(&script);
    if (seals) seal_all(script.file);
    H5Fclose(script.file);
    H5Pclose(access);
    const int fd = open(scratch_path, O_RDWR | O_CLOEXEC);
    PROMISE(fd >= 0 && !seal_write(fd, scratch_path, &(SealNote){.number = 1}, NULL));
    close(fd);
    read_it();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const bool file = size >= 4 && !memcmp(data, "MENI", 4);
    if (file) read_bytes(data, size);
    else if (size) read_changed(data, size);
    return 0;
}
