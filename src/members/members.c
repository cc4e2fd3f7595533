/*
  The task `ensemble`: runs of all members, on groups of ranks.

  Member m belongs to group m modulo their number. A member is a scene of its own, as its options file says, and is run
  as any other; groups know nothing of each other until all have ended.
*/
#include <string.h>
#include "io/io.h"
#include "observe/results.h"
#include "observe/signals.h"
#include "options/record.h"
#include "ensemble/ensemble.h"
#include "model/build.h"
#include "members/members.h"

/* Work of this rank's group. */
typedef struct {
  MpmModel    model; /* the scene */
  MPI_Comm    comm;
  PetscInt    number;
  PetscMPIInt rank;
  PetscBool  *there; /* members that have been run before */
  PetscReal   seconds;
  PetscBool   checked; /* results that are asked for have been found in a member */
  PetscBool   interrupted;
  char        message[MPM_MEMBER_TEXT]; /* fault that ends the ensemble; empty: none */
} Group;

/* ---- terminal ---- */

static PetscErrorCode PrintBegin(const MpmModel model, PetscInt there)
{
  const MpmEnsemble *ensemble = model->ensemble;

  PetscFunctionBeginUser;
  if (!MpmTerminalShows(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(model->comm, "talus %s: ensemble of %d members, %d draws, %d group%s of ranks\n", MPM_VERSION,
                        (int)ensemble->members, (int)ensemble->draw_count, (int)ensemble->groups,
                        ensemble->groups > 1 ? "s" : ""));
  if (there) PetscCall(PetscPrintf(model->comm, "%d members have been run already\n", (int)there));
  PetscCall(PetscPrintf(model->comm, "%7s %10s %10s  %s\n", "member", "status", "seconds", "draws"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintMember(const Group *group, PetscInt m, const MpmMember *member)
{
  static const char *const words[]  = {"completed", "", "refused", "gave up"};
  const MpmEnsemble       *ensemble = group->model->ensemble;
  char                    *text     = NULL;

  PetscFunctionBeginUser;
  if (!MpmTerminalShows(group->model)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < PetscMin(ensemble->draw_count, 6); k++)
    PetscCall(MpmTextAppend(&text, " %s %.6g", ensemble->draws[k].name, (double)MpmDrawValue(ensemble, k, m)));
  PetscCall(PetscPrintf(group->comm, "%7d %10s %10.3g %s%s%s\n", (int)m, words[member->status], (double)member->seconds,
                        text ? text : "", member->why[0] ? ": " : "", member->why));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a member ---- */

/* Refusals belong to the member; anything else is a fault of the program or the machine. */
static PetscErrorCode HandleError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  if (code != MPM_ERR_INPUT) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, NULL);
  if (type == PETSC_ERROR_INITIAL) (void)PetscStrncpy((char *)ctx, message ? message : "", MPM_MEMBER_TEXT);
  return code;
}

/* Steps and summary. */
static PetscErrorCode TakeSteps(MpmModel other)
{
  PetscBool interrupted;

  PetscFunctionBeginUser;
  PetscCall(MpmModelRunSteps(other, &interrupted));
  PetscCall(MpmModelRunEnd(other, interrupted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunScene(const Group *group, MpmModel other)
{
  const MpmForceField *force = &group->model->scene.body_force;

  PetscFunctionBeginUser;
  other->record->sources = group->model->record->sources;
  PetscCall(MpmModelSetBodyForce(other, force->function, force->ctx));
  PetscCall(MpmModelSetFromOptions(other));
  PetscCall(MpmModelSetUp(other));
  MpmModelCall(other, TakeSteps(other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True on all ranks of the group where a signal asks for the end. */
static PetscErrorCode FindSignal(Group *group)
{
  group->interrupted = MpmSignalsCaught();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &group->interrupted, 1, MPM_MPI_BOOL, MPI_LOR, group->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Results that are asked for must be there in the first member that has any. */
static PetscErrorCode CheckResults(Group *group, const char prefix[])
{
  MpmMember member = {0};

  PetscFunctionBeginUser;
  if (group->checked) PetscFunctionReturn(PETSC_SUCCESS);
  group->checked = PETSC_TRUE;
  if (!group->rank) PetscCall(MpmMemberCollect(group->model->ensemble, prefix, &member, group->message));
  PetscCallMPI(MPI_Bcast(group->message, MPM_MEMBER_TEXT, MPI_CHAR, 0, group->comm));
  PetscCall(MpmMemberDestroy(&member));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunMember(Group *group, PetscInt m)
{
  MpmMember      member = {0};
  MpmModel       other;
  PetscLogDouble since, now;
  PetscErrorCode error;
  char           prefix[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  MpmMemberPrefix(group->model, m, prefix);
  PetscCall(MpmDrawsSetOptions(group->model->ensemble, m, prefix));
  PetscCall(PetscTime(&since));
  PetscCall(MpmModelCreate(group->comm, &other));
  PetscCall(PetscPushErrorHandler(HandleError, member.why));
  error = RunScene(group, other);
  PetscCall(PetscPopErrorHandler());
  if (error && error != MPM_ERR_INPUT) PetscCall(error);
  if (error) member.status = MPM_MEMBER_REFUSED;
  else if (other->caller.outcome.code) {
    member.status = MPM_MEMBER_FAILED;
    PetscCall(PetscStrncpy(member.why, other->caller.outcome.text, sizeof(member.why)));
  }
  PetscCall(MpmModelDestroy(&other));
  PetscCall(PetscTime(&now));
  member.seconds = (PetscReal)(now - since);
  group->seconds += member.seconds;
  PetscCall(FindSignal(group));
  if (group->interrupted) PetscFunctionReturn(PETSC_SUCCESS);
  if (!member.status) PetscCall(CheckResults(group, prefix));
  PetscCall(MpmMemberWrite(group->comm, group->model, m, &member));
  PetscCall(PrintMember(group, m, &member));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all members ---- */

/* Members that have been run before, as the first rank finds them. */
static PetscErrorCode FindThere(const MpmModel model, PetscBool there[])
{
  const MpmEnsemble *ensemble = model->ensemble;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < ensemble->members && !model->rank; m++) {
    MpmMember member = {0};

    if (ensemble->restart) PetscCall(MpmMemberRead(model, m, &member, &there[m]));
    if (!there[m]) PetscCall(MpmMemberRemove(model, m));
    PetscCall(MpmMemberDestroy(&member));
  }
  PetscCallMPI(MPI_Bcast(there, (PetscMPIInt)ensemble->members, MPM_MPI_BOOL, 0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GroupCreate(MpmModel model, Group *group)
{
  const PetscInt groups = model->ensemble->groups;
  PetscInt       there  = 0;
  char           prefix[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  *group        = (Group){.model = model};
  group->number = (PetscInt)((PetscInt64)model->rank * groups / model->size);
  PetscCallMPI(MPI_Comm_split(model->comm, (int)group->number, model->rank, &group->comm));
  PetscCallMPI(MPI_Comm_rank(group->comm, &group->rank));
  PetscCall(PetscCalloc1(model->ensemble->members, &group->there));
  PetscCall(FindThere(model, group->there));
  MpmMemberPrefix(model, 0, prefix);
  PetscCall(MpmFolderMake(model->comm, prefix));
  for (PetscInt m = 0; m < model->ensemble->members; m++) there += group->there[m] ? 1 : 0;
  PetscCall(PrintBegin(model, there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunGroup(Group *group)
{
  const MpmEnsemble *ensemble = group->model->ensemble;

  PetscFunctionBeginUser;
  for (PetscInt m = group->number; m < ensemble->members; m += ensemble->groups) {
    if (group->interrupted || group->message[0]) break;
    if (!group->there[m]) PetscCall(RunMember(group, m));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fault of any rank ends all of them. */
static PetscErrorCode CheckMessage(const MpmModel model, char message[])
{
  PetscMPIInt at = message[0] ? model->rank : model->size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &at, 1, MPI_INT, MPI_MIN, model->comm));
  if (at == model->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(message, MPM_MEMBER_TEXT, MPI_CHAR, at, model->comm));
  MpmCheckInput(PETSC_FALSE, "%s", message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunGroups(Group *group)
{
  PetscErrorCode error = RunGroup(group);

  PetscFunctionBeginUser;
  if (error && group->model->ensemble->groups > 1) MPI_Abort(group->model->comm, 1); /* the others do not wait for it */
  PetscCall(error);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &group->interrupted, 1, MPM_MPI_BOOL, MPI_LOR, group->model->comm));
  PetscCall(CheckMessage(group->model, group->message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results ---- */

/* Members as their files have them, on the first rank; other ranks have none. */
static PetscErrorCode ReadMembers(Group *group, MpmMember members[])
{
  const MpmModel model = group->model;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->ensemble->members && !model->rank && !group->message[0]; m++) {
    char prefix[PETSC_MAX_PATH_LEN];

    PetscCall(MpmMemberRead(model, m, &members[m], &members[m].run));
    MpmMemberPrefix(model, m, prefix);
    if (members[m].run && !members[m].status)
      PetscCall(MpmMemberCollect(model->ensemble, prefix, &members[m], group->message));
  }
  PetscCall(CheckMessage(model, group->message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Wall time since the start, of the members, and beside those of the group that took longest. */
static PetscErrorCode FindTimes(const Group *group, PetscLogDouble since, MpmEnsembleTimes *times)
{
  PetscReal      longest = group->seconds;
  PetscLogDouble now;

  PetscFunctionBeginUser;
  times->members = group->rank ? 0. : group->seconds;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &times->members, 1, MPIU_REAL, MPIU_SUM, group->model->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &longest, 1, MPIU_REAL, MPIU_MAX, group->model->comm));
  PetscCall(PetscTime(&now));
  times->all = (PetscReal)(now - since);
  times->own = times->all - longest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tables, maps and summary. */
static PetscErrorCode WriteResults(Group *group, PetscLogDouble since, int *status)
{
  MpmModel         model = group->model;
  MpmEnsembleTimes times;
  MpmMember       *members;
  PetscInt         count = 0;
  char             why[MPM_MEMBER_TEXT];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(model->ensemble->members, &members));
  PetscCall(ReadMembers(group, members));
  PetscCall(MpmEnsembleWriteTables(model, members));
  PetscCall(MpmEnsembleWriteMaps(model, members));
  PetscCall(FindTimes(group, since, &times));
  PetscCall(MpmEnsembleWriteSummary(model, members, &times, group->interrupted));
  PetscCall(PetscStrncpy(why, members[0].why, sizeof(why)));
  for (PetscInt m = 0; m < model->ensemble->members; m++) {
    count += members[m].run && !members[m].status ? 1 : 0;
    PetscCall(MpmMemberDestroy(&members[m]));
  }
  PetscCall(PetscFree(members));
  PetscCallMPI(MPI_Bcast(&count, 1, MPIU_INT, 0, model->comm));
  *status = count || group->interrupted ? 0 : MPM_EXIT_GAVEUP;
  if (group->interrupted)
    PetscCall(MpmTerminalWarn(model, "interrupted; with -mpm_ensemble_restart the ensemble goes on with the rest"));
  else if (!count) PetscCall(MpmTerminalWarn(model, "no member was completed; the first: %s", why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleRun(MpmModel model, int *status)
{
  PetscLogDouble since;
  Group          group;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(GroupCreate(model, &group));
  PetscCall(RunGroups(&group));
  PetscCall(WriteResults(&group, since, status));
  PetscCall(PetscFree(group.there));
  PetscCallMPI(MPI_Comm_free(&group.comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
