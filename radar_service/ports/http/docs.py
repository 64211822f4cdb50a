"""The documentation page of the REST interface, at /docs: Swagger UI, whose files come from the package fastapi-offline.

The page loads nothing from other servers and has no inline scripts, so the server's content security policy holds.
"""

from importlib import resources

from fastapi import FastAPI, Response
from fastapi.responses import HTMLResponse
from starlette.staticfiles import StaticFiles

from radar_service.ports.roles import needs

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>radar-service: REST</title>
<link rel="stylesheet" href="docs/files/swagger-ui.css">
<link rel="icon" href="icon.svg">
</head>
<body>
<div id="swagger-ui"></div>
<script src="docs/files/swagger-ui-bundle.js"></script>
<script src="docs/start.js"></script>
</body>
</html>
"""

# The token is the one that the page of the radar keeps for this browser tab (clients/web/api.js).
START = """const KEPT = "radar-token";
const show = () =>
  SwaggerUIBundle({
    url: new URL("api/openapi.json", document.baseURI).href,
    dom_id: "#swagger-ui",
    deepLinking: true,
    requestInterceptor: (request) => {
      const token = sessionStorage.getItem(KEPT);
      if (token) request.headers.Authorization = `Bearer ${token}`;
      return request;
    },
    responseInterceptor: (response) => {
      if (response.status !== 401) return response;
      const token = window.prompt("This server needs a token");
      if (token) {
        sessionStorage.setItem(KEPT, token.trim());
        setTimeout(show);
      }
      return response;
    },
  });
show();
"""


def add_docs(app: FastAPI) -> None:
    """Adds the page and its files to an application."""

    @needs("nothing")
    async def page() -> HTMLResponse:
        return HTMLResponse(PAGE)

    @needs("nothing")
    async def start() -> Response:
        return Response(START, media_type="text/javascript")

    app.add_api_route("/docs", page, include_in_schema=False)
    app.add_api_route("/docs/start.js", start, include_in_schema=False)
    files = resources.files("fastapi_offline").joinpath("static")
    app.mount("/docs/files", needs("nothing")(StaticFiles(directory=str(files))))
