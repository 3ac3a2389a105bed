/* SPDX-License-Identifier: BSD-3-Clause */
/* The metrics of a daemon: one table, and the functions that find their values. Units are SI, counters only rise while the daemon
 * and, where the table says so, the run last. */
#include "http/metrics.h"

#include "base/clock.h"
#include <math.h>

typedef void Print(Exposition *to, const Family *family, const View *view);

/* --- numbers ----------------------------------------------------------------------------------------------------------- */

static double steps(const View *view)
{
    return (double)view->run->steps;
}

static double stepping(const View *view)
{
    return view->run->stepping;
}

static double step(const View *view)
{
    return (double)view->run->progress.step;
}

static double time_step(const View *view)
{
    return view->run->progress.dt;
}

static double simulated(const View *view)
{
    return view->run->progress.t;
}

static double end_time(const View *view)
{
    return view->run->end_time;
}

static double remaining(const View *view)
{
    return view->run->eta;
}

static double threads(const View *view)
{
    return view->run->threads;
}

static double memory(const View *view)
{
    return (double)view->run->bytes;
}

static double rebuilds(const View *view)
{
    return (double)view->run->progress.rebuilds;
}

static double guarded(const View *view)
{
    return (double)view->run->progress.guarded;
}

static double uncorrected(const View *view)
{
    return (double)view->run->uncorrected;
}

static double energy_excess(const View *view)
{
    return view->run->energy_excess;
}

static double probe_time(const View *view)
{
    return view->run->sampled ? view->run->sampled_at : NAN;
}

static double beats(const View *view)
{
    return (double)view->counts.beats;
}

static double orders(const View *view)
{
    return (double)view->counts.orders;
}

static double writer_files(const View *view)
{
    return view->counts.files;
}

static double writer_rows(const View *view)
{
    return view->counts.rows;
}

static double notes(const View *view)
{
    return (double)view->counts.notes;
}

static double disk_size(const View *view)
{
    return view->disk.size;
}

static double disk_free(const View *view)
{
    return view->disk.free;
}

static double clients(const View *view)
{
    return (double)view->from->traffic->clients;
}

static double listeners(const View *view)
{
    return (double)view->from->traffic->listeners;
}

static double requests(const View *view)
{
    return (double)view->from->traffic->requests;
}

static double refused(const View *view)
{
    return (double)view->from->traffic->refused;
}

static double unread(const View *view)
{
    return (double)view->from->traffic->unread;
}

static double stream_memory(const View *view)
{
    return (double)(view->from->traffic->streams.memory + view->from->traffic->streams.copies);
}

static double streams_slow(const View *view)
{
    return (double)view->from->traffic->streams.too_slow;
}

static double streams_packed(const View *view)
{
    return (double)view->from->traffic->streams.packed;
}

static double streams_let_go(const View *view)
{
    return (double)view->from->traffic->streams.let_go;
}

static double streams_not_made(const View *view)
{
    return (double)view->from->traffic->streams.not_made;
}

static double streams_unheard(const View *view)
{
    return (double)view->from->traffic->streams.unheard;
}

static double streams_refused(const View *view)
{
    return (double)view->from->traffic->streams.refused;
}

static double without_room(const View *view)
{
    return (double)view->from->traffic->streams.without_room;
}

static double denied(const View *view)
{
    return (double)view->from->traffic->denied;
}

static double gate_restarts(const View *view)
{
    return (double)view->from->traffic->gate_restarts;
}

static double shown_out(const View *view)
{
    return (double)view->from->traffic->shown_out;
}

static double lease(const View *view)
{
    const double left = view->run->lease.until - clock_now();
    return view->run->lease.epoch && left > 0 ? left : 0;
}

static double journaled(const View *view)
{
    return (double)view->counts.journal.records;
}

static double not_journaled(const View *view)
{
    return (double)view->counts.journal.failures;
}

static double journal_seconds(const View *view)
{
    return view->counts.journal.seconds;
}

static double connections(const View *view)
{
    return view->http.connections;
}

static double crowded_out(const View *view)
{
    return (double)view->http.crowded_out;
}

static double cpu(const View *view)
{
    return view->process.cpu;
}

static double resident(const View *view)
{
    return view->process.resident;
}

static double virtual(const View *view)
{
    return view->process.virtual;
}

static double fds(const View *view)
{
    return view->process.fds;
}

static double max_fds(const View *view)
{
    return view->process.max_fds;
}

static double began(const View *view)
{
    return view->http.began;
}

/* --- numbers of several things ------------------------------------------------------------------------------------------ */

static void one(Exposition *to, const Family *family, double value, const char *label, const char *of)
{
    exposition_sample(to, family, value, 1, &(Label){label, of});
}

static void build(Exposition *to, const Family *family, const View *view)
{
    const Label labels[] = {{"version", MENISCUS_VERSION},
                            {"commit", view->from->commit},
                            {"compiler", view->from->compiler},
                            {"level", mns_level()},
                            {"arithmetic", mns_arithmetic()}};
    exposition_sample(to, family, 1, sizeof labels / sizeof *labels, labels);
}

static void name(Exposition *to, const Family *family, const View *view)
{
    one(to, family, 1, "name", view->from->name);
}

static void run(Exposition *to, const Family *family, const View *view)
{
    const Document *document = view->run->document;
    const Label labels[] = {
        {"case", document->name}, {"scheme", document->c->scheme.name}, {"title", document->c->title}};
    exposition_sample(to, family, 1, sizeof labels / sizeof *labels, labels);
}

static void state(Exposition *to, const Family *family, const View *view)
{
    for (int k = 0; k < RUN_STATES; k++)
        one(to, family, view->run->state == (RunState)k, "state", run_state_name((RunState)k));
}

/* What can put a run into FAULT is there from the beginning, so that the first one is seen to be one more. */
static void faults(Exposition *to, const Family *family, const View *view)
{
    const unsigned usual = 1u << MNS_E_DIVERGED | 1u << MNS_E_NO_SPACE | 1u << MNS_E_IO;
    for (int k = 1; k < FIGURES_REASONS; k++)
        if (view->run->faults[k] || usual >> k & 1)
            one(to, family, (double)view->run->faults[k], "reason", mns_status_name((MnsStatus)k));
}

static double missing(const View *view)
{
    return view->run->state == RUN_EMPTY && view->run->fault.status;
}

static void pass_seconds(Exposition *to, const Family *family, const View *view)
{
    const RunFigures *figures = view->run;
    for (size_t k = 0; k < figures->n_timers; k++)
        one(to, family, figures->timers[k].seconds, "pass", figures->timers[k].name);
}

static void pass_calls(Exposition *to, const Family *family, const View *view)
{
    const RunFigures *figures = view->run;
    for (size_t k = 0; k < figures->n_timers; k++)
        one(to, family, (double)figures->timers[k].calls, "pass", figures->timers[k].name);
}

static void particles(Exposition *to, const Family *family, const View *view)
{
    const MnsCase *c = view->run->document->c;
    for (size_t k = 0; k < c->n_fluids + c->n_walls; k++) {
        const bool fluid = k < c->n_fluids;
        const Label labels[] = {{"kind", fluid ? "fluid" : "wall"},
                                {"phase", fluid ? c->fluids[k].name : c->walls[k - c->n_fluids].name}};
        exposition_sample(to, family, (double)view->run->particles[k], 2, labels);
    }
}

static void probes(Exposition *to, const Family *family, const View *view)
{
    const MnsCase *c = view->run->document->c;
    for (size_t k = 0; view->run->sampled && k < c->n_probes; k++) {
        const Label labels[] = {{"probe", c->probes[k].name}, {"unit", mns_probe_unit(&c->probes[k])}};
        exposition_sample(to, family, view->run->probes[k], 2, labels);
    }
}

static void files(Exposition *to, const Family *family, double checkpoints, double snapshots)
{
    one(to, family, checkpoints, "kind", "checkpoint");
    one(to, family, snapshots, "kind", "snapshot");
}

static void files_written(Exposition *to, const Family *family, const View *view)
{
    files(to, family, (double)view->counts.checkpoints.written, (double)view->counts.snapshots.written);
}

static void files_failed(Exposition *to, const Family *family, const View *view)
{
    files(to, family, (double)view->counts.checkpoints.failed, (double)view->counts.snapshots.failed);
}

static void files_seconds(Exposition *to, const Family *family, const View *view)
{
    files(to, family, view->counts.checkpoints.seconds, view->counts.snapshots.seconds);
}

static void files_latest(Exposition *to, const Family *family, const View *view)
{
    files(to, family, view->counts.checkpoints.latest, view->counts.snapshots.latest);
}

static void topic_messages(Exposition *to, const Family *family, const View *view)
{
    const TopicTraffic *topics = view->from->traffic->topics;
    for (int k = 0; k < TRAFFIC_TOPICS; k++) one(to, family, (double)topics[k].messages, "topic", topics[k].name);
}

static void topic_bytes(Exposition *to, const Family *family, const View *view)
{
    const TopicTraffic *topics = view->from->traffic->topics;
    for (int k = 0; k < TRAFFIC_TOPICS; k++) one(to, family, (double)topics[k].bytes, "topic", topics[k].name);
}

/* A count for each kind of stream. */
static void of_streams(Exposition *to, const Family *family, const _Atomic uint64_t *counts)
{
    static const char *const kinds[TRAFFIC_STREAMS] = {"probes", "fields", "events", "series", "snapshots"};
    for (int k = 0; k < TRAFFIC_STREAMS; k++) one(to, family, (double)counts[k], "what", kinds[k]);
}

static void streams_open(Exposition *to, const Family *family, const View *view)
{
    of_streams(to, family, view->from->traffic->streams.open);
}

static void stream_items(Exposition *to, const Family *family, const View *view)
{
    of_streams(to, family, view->from->traffic->streams.items);
}

static void stream_bytes(Exposition *to, const Family *family, const View *view)
{
    of_streams(to, family, view->from->traffic->streams.bytes);
}

static void stream_skips(Exposition *to, const Family *family, const View *view)
{
    of_streams(to, family, view->from->traffic->streams.skipped);
}

static void stream_cancels(Exposition *to, const Family *family, const View *view)
{
    of_streams(to, family, view->from->traffic->streams.cancelled);
}

static void topic_skips(Exposition *to, const Family *family, const View *view)
{
    const TopicTraffic *topics = view->from->traffic->topics;
    one(to, family, (double)(view->counts.progress_dropped + topics[TRAFFIC_PROGRESS].thinned), "topic", "progress");
    one(to, family, (double)(view->counts.samples_dropped + topics[TRAFFIC_PROBE].thinned), "topic", "probe");
}

static void keys(Exposition *to, const Family *family, const View *view)
{
    static const char *const roles[TRAFFIC_ROLES] = {"viewer", "operator", "admin"};
    for (int k = 0; k < TRAFFIC_ROLES; k++) one(to, family, (double)view->from->traffic->keys[k], "role", roles[k]);
}

static void handshakes_failed(Exposition *to, const Family *family, const View *view)
{
    static const char *const reasons[TRAFFIC_FAILURES] = {"key", "protocol", "silence"};
    for (int k = 0; k < TRAFFIC_FAILURES; k++)
        one(to, family, (double)(view->from->traffic->failures[k] + view->from->traffic->gate_failures[k]), "reason",
            reasons[k]);
}

static void answers(Exposition *to, const Family *family, const View *view)
{
    for (int k = 0; k < HTTP_CODES; k++) {
        char code[16];
        snprintf(code, sizeof code, "%u", http_codes[k]);
        one(to, family, (double)view->http.answers[k], "code", code);
    }
}

/* --- the table --------------------------------------------------------------------------------------------------------- */

typedef struct Metric {
    Family family;
    bool of_run;                        /* only with a case */
    double (*number)(const View *view); /* NAN: there is none now */
    Print *print;                       /* instead, for several   */
} Metric;

static const Metric metrics[] = {
    {{"meniscus_build", "", METRIC_INFO, "The program and the instruction set it uses"}, .print = build},
    {{"meniscus_daemon", "", METRIC_INFO, "The name of the daemon"}, .print = name},
    {{"meniscus_run_state", "", METRIC_GAUGE, "1 for the state the run is in, 0 for the others"}, .print = state},
    {{"meniscus_faults", "", METRIC_COUNTER, "Times a run came to a FAULT"}, .print = faults},
    {{"meniscus_run_missing", "", METRIC_GAUGE, "1 while EMPTY as a run could not be brought back; /readyz says why"},
     .number = missing},
    {{"meniscus_steps", "", METRIC_COUNTER, "Time steps done since the daemon began"}, .number = steps},
    {{"meniscus_stepping", "seconds", METRIC_COUNTER, "Wall-clock time in them"}, .number = stepping},
    {{"meniscus_heartbeats", "", METRIC_COUNTER, "Signs of life of the solver: it stands still if the solver hangs"},
     .number = beats},

    {{"meniscus_run", "", METRIC_INFO, "The case and its scheme"}, true, .print = run},
    {{"meniscus_run_step", "", METRIC_GAUGE, "Time step the run is at"}, true, .number = step},
    {{"meniscus_run_time", "seconds", METRIC_GAUGE, "Simulated time"}, true, .number = simulated},
    {{"meniscus_run_end_time", "seconds", METRIC_GAUGE, "Simulated time at which the run is done"},
     true,
     .number = end_time},
    {{"meniscus_run_time_step", "seconds", METRIC_GAUGE, "Length of the latest time step"}, true, .number = time_step},
    {{"meniscus_run_remaining", "seconds", METRIC_GAUGE, "Wall-clock time to the end, while RUNNING"},
     true,
     .number = remaining},
    {{"meniscus_particles", "", METRIC_GAUGE, "Particles by phase"}, true, .print = particles},
    {{"meniscus_solver_threads", "", METRIC_GAUGE, "Threads of the solver"}, true, .number = threads},
    {{"meniscus_solver_memory", "bytes", METRIC_GAUGE,
      "Memory of particles, neighbour lists and pressure system, without multigrid's"},
     true,
     .number = memory},
    {{"meniscus_solver_pass", "seconds", METRIC_COUNTER,
      "Wall-clock time of the runner by pass of the scheme, for outputs and between steps, since the case was loaded"},
     true,
     .print = pass_seconds},
    {{"meniscus_solver_pass_calls", "", METRIC_COUNTER, "How often each of them was done, since the case was loaded"},
     true,
     .print = pass_calls},
    {{"meniscus_solver_rebuilds", "", METRIC_COUNTER, "Neighbour lists built in this run"}, true, .number = rebuilds},
    {{"meniscus_solver_guarded", "", METRIC_COUNTER, "Times a particle of this run was kept from entering a wall"},
     true,
     .number = guarded},
    {{"meniscus_solver_uncorrected", "", METRIC_COUNTER,
      "Steps since the case was loaded after which a number density was off by more than the case allows"},
     true,
     .number = uncorrected},
    {{"meniscus_solver_energy_excess", "ratio", METRIC_GAUGE,
      "Energy that the scheme has made of nothing, over the largest of kinetic energy and change of potential energy"},
     true,
     .number = energy_excess},
    {{"meniscus_probe_value", "", METRIC_GAUGE, "Latest sample of each probe, in the unit that its label says"},
     true,
     .print = probes},
    {{"meniscus_probe_time", "seconds", METRIC_GAUGE, "Simulated time of the latest samples"},
     true,
     .number = probe_time},

    {{"meniscus_orders_waiting", "", METRIC_GAUGE, "Commands that wait for the next step boundary"}, .number = orders},
    {{"meniscus_writer_files_waiting", "", METRIC_GAUGE, "Files that wait for the disk; at 2 the solver waits too"},
     .number = writer_files},
    {{"meniscus_writer_rows_waiting", "", METRIC_GAUGE, "Samples of probes that wait to be written"},
     .number = writer_rows},
    {{"meniscus_output_files", "", METRIC_COUNTER, "Files written"}, .print = files_written},
    {{"meniscus_output_failures", "", METRIC_COUNTER, "Attempts to write one that failed"}, .print = files_failed},
    {{"meniscus_output", "seconds", METRIC_COUNTER, "Time spent on writing them"}, .print = files_seconds},
    {{"meniscus_output_latest_timestamp", "seconds", METRIC_GAUGE, "When the latest was written, since 1970; 0: none"},
     .print = files_latest},
    {{"meniscus_journal_records", "", METRIC_COUNTER, "Records of journals"}, .number = journaled},
    {{"meniscus_journal_failures", "", METRIC_COUNTER, "Times they could not be had on the disk"},
     .number = not_journaled},
    {{"meniscus_journal", "seconds", METRIC_COUNTER, "Time the solver waited for that"}, .number = journal_seconds},
    {{"meniscus_disk_size", "bytes", METRIC_GAUGE, "Size of the disk that runs are on"}, .number = disk_size},
    {{"meniscus_disk_free", "bytes", METRIC_GAUGE, "What is free on it for the daemon"}, .number = disk_free},

    {{"meniscus_lease", "seconds", METRIC_GAUGE, "How long the lease lives on; 0: nobody holds one"}, .number = lease},
    {{"meniscus_access_keys", "", METRIC_GAUGE, "Keys that are let in from afar"}, .print = keys},
    {{"meniscus_access_handshakes_failed", "", METRIC_COUNTER,
      "Connections to the control socket that were not let in"},
     .print = handshakes_failed},
    {{"meniscus_access_denied", "", METRIC_COUNTER, "Requests that take a role which their key lacks"},
     .number = denied},
    {{"meniscus_access_shown_out", "", METRIC_COUNTER,
      "Connections from afar ended for sending without an end, faster than is taken, or beyond what their key may "
      "have"},
     .number = shown_out},
    {{"meniscus_gate_restarts", "", METRIC_COUNTER,
      "Times the process that those from afar go through has died or hung"},
     .number = gate_restarts},
    {{"meniscus_control_clients", "", METRIC_GAUGE, "Connections to the control socket"}, .number = clients},
    {{"meniscus_control_requests", "", METRIC_COUNTER, "Requests that came"}, .number = requests},
    {{"meniscus_control_failures", "", METRIC_COUNTER, "Those refused, and those that failed or were called off"},
     .number = refused},
    {{"meniscus_control_unread", "bytes", METRIC_GAUGE, "Replies that clients have not taken yet"}, .number = unread},
    {{"meniscus_telemetry_clients", "", METRIC_GAUGE, "Connections to the telemetry socket"}, .number = listeners},
    {{"meniscus_telemetry_messages", "", METRIC_COUNTER, "Messages published"}, .print = topic_messages},
    {{"meniscus_telemetry", "bytes", METRIC_COUNTER, "Bytes published, once for all who subscribe"},
     .print = topic_bytes},
    {{"meniscus_telemetry_skipped", "", METRIC_COUNTER, "Messages given up because newer ones came; files have all"},
     .print = topic_skips},
    {{"meniscus_telemetry_waiting", "", METRIC_GAUGE, "Samples and progress that wait to be published"},
     .number = notes},
    {{"meniscus_streams", "", METRIC_GAUGE, "Streams that are subscribed to"}, .print = streams_open},
    {{"meniscus_stream_items", "", METRIC_COUNTER, "Items sent whole"}, .print = stream_items},
    {{"meniscus_stream", "bytes", METRIC_COUNTER, "Bytes of items sent, with what is said of them"},
     .print = stream_bytes},
    {{"meniscus_stream_skipped", "", METRIC_COUNTER, "Items that were due and gave way to newer ones"},
     .print = stream_skips},
    {{"meniscus_stream_cancelled", "", METRIC_COUNTER, "Items cancelled by who got them"}, .print = stream_cancels},
    {{"meniscus_streams_too_slow", "", METRIC_COUNTER, "Items under way given up because memory was short"},
     .number = streams_slow},
    {{"meniscus_streams_packed", "", METRIC_COUNTER, "Items packed, once for all who get them"},
     .number = streams_packed},
    {{"meniscus_streams_let_go", "", METRIC_COUNTER, "Items that waited for credit and made room for others"},
     .number = streams_let_go},
    {{"meniscus_streams_not_made", "", METRIC_COUNTER, "Items that were due and for which there was no memory"},
     .number = streams_not_made},
    {{"meniscus_streams_unheard", "", METRIC_COUNTER, "Requests of clients that do not read the replies"},
     .number = streams_unheard},
    {{"meniscus_streams_without_room", "", METRIC_COUNTER, "Steps at which items were due and there was no room"},
     .number = without_room},
    {{"meniscus_streams_refused", "", METRIC_COUNTER, "Requests for streams that were refused"},
     .number = streams_refused},
    {{"meniscus_streams_memory", "bytes", METRIC_GAUGE, "Held by streams: copies of fields, and items"},
     .number = stream_memory},

    {{"meniscus_http_connections", "", METRIC_GAUGE, "Connections to this port"}, .number = connections},
    {{"meniscus_http_crowded_out", "", METRIC_COUNTER, "Connections closed to make room for newer ones"},
     .number = crowded_out},
    {{"meniscus_http_answers", "", METRIC_COUNTER, "Answers given here"}, .print = answers},

    {{"process_cpu", "seconds", METRIC_COUNTER, "Time on processors, of all threads"}, .number = cpu},
    {{"process_resident_memory", "bytes", METRIC_GAUGE, "Resident memory"}, .number = resident},
    {{"process_virtual_memory", "bytes", METRIC_GAUGE, "Virtual memory"}, .number = virtual},
    {{"process_open_fds", "", METRIC_GAUGE, "Open files and sockets"}, .number = fds},
    {{"process_max_fds", "", METRIC_GAUGE, "How many there may be"}, .number = max_fds},
    {{"process_start_time", "seconds", METRIC_GAUGE, "When the daemon began, since 1970"}, .number = began},
};

void metrics_print(Exposition *to, const View *view)
{
    for (size_t k = 0; k < sizeof metrics / sizeof *metrics; k++) {
        const Metric *metric = &metrics[k];
        if (metric->of_run && !view->run->document) continue;
        const double value = metric->number ? metric->number(view) : NAN;
        if (metric->print) metric->print(to, &metric->family, view);
        else if (!isnan(value)) exposition_sample(to, &metric->family, value, 0, NULL);
    }
}
