# The README's steps in an image. It is open to other machines, so it wants a token:
#   docker build -t radar-service . && openssl rand -hex 16 > token
#   docker run --restart=always -p 8000:8000 -v "$PWD/token:/run/secrets/radar-token:ro" radar-service
# For a build that can be repeated, give the base by its digest, as `docker buildx imagetools inspect python:3.11-slim` shows it:
#   docker build --build-arg BASE=python:3.11-slim@sha256:... -t radar-service .
ARG BASE=python:3.11-slim
FROM ${BASE}
RUN useradd --create-home radar && install -d -o radar -g radar /home/radar/radar-service
WORKDIR /home/radar/radar-service
USER radar
RUN python3 -m venv .venv
# Dependencies have layers of their own: a change of the program does not install them again.
COPY --chown=radar pyproject.toml constraints.txt ./
RUN python3 -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['dependencies'], sep='\n')" > needed.txt \
  && .venv/bin/pip install --no-cache-dir -r needed.txt -c constraints.txt
COPY --chown=radar . .
# The base has no C compiler: pip fetches one for the build alone, by the first name, and from 25.3 on by the second.
RUN PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt .venv/bin/pip install --no-cache-dir --no-deps .
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
  CMD [".venv/bin/python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/api/health/ready', timeout=2)"]
STOPSIGNAL SIGTERM
ENTRYPOINT [".venv/bin/radar-service", "serve", "--host", "0.0.0.0", "--token-file", "/run/secrets/radar-token", "--exit-when-failed"]
