"""REST: work that takes long, followed and cancelled."""

from fastapi import APIRouter

from radar_service.stream.http import schemas
from radar_service.stream.http.answers import REFUSED, UNKNOWN
from radar_service.stream.http.scene_routes import not_found
from radar_service.stream.jobs import JobQueue
from radar_service.stream.ports.roles import needs


def job_routes(jobs: JobQueue) -> APIRouter:
    """Returns the routes under /jobs."""
    router = APIRouter(tags=["jobs"])

    @router.get("/jobs")
    @needs("read")
    async def list_jobs() -> list[schemas.JobState]:
        """Returns the jobs that wait or run, and the last ones that have ended."""
        return [schemas.JobState.model_validate(job.as_dict()) for job in jobs.jobs]

    @router.get("/jobs/{job}", responses={**UNKNOWN, **REFUSED})
    @needs("read")
    async def get_job(job: str) -> schemas.JobState:
        """Returns how far a job is."""
        with not_found("job", job):
            return schemas.JobState.model_validate(jobs.job(job).as_dict())

    @router.delete("/jobs/{job}", status_code=204, responses={**UNKNOWN, **REFUSED})
    @needs("command")
    async def cancel_job(job: str) -> None:
        """Cancels a job; the request that waits for it is answered with 409."""
        with not_found("job", job):
            jobs.job(job).cancel()

    return router
