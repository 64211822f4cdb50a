# The README's steps in an image. It is open to other machines, so it wants a token:
#   docker build -t radar-service . && openssl rand -hex 16 > token
#   docker run -p 8000:8000 -v "$PWD/token:/run/secrets/radar-token:ro" radar-service
FROM python:3.11-slim
RUN useradd --create-home radar
WORKDIR /home/radar/radar-service
COPY --chown=radar . .
USER radar
RUN python3 -m venv .venv && .venv/bin/pip install --no-cache-dir .
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
  CMD [".venv/bin/python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/api/health/ready', timeout=2)"]
STOPSIGNAL SIGTERM
ENTRYPOINT [".venv/bin/radar-service", "serve", "--host", "0.0.0.0", "--token-file", "/run/secrets/radar-token"]
